"""Run by .ci/run where numpy alone is installed: what was made there is a performance that moves."""

import importlib.util
import sys

import numpy as np

for name in ("torch", "scipy", "pocketsphinx"):
    assert importlib.util.find_spec(name) is None, f"{name} is installed"
with np.load(sys.argv[1]) as motion:
    directions = motion["directions"]
assert np.abs(np.linalg.norm(directions, axis=-1) - 1).max() < 1e-4
assert np.linalg.norm(np.diff(directions, axis=0), axis=-1).max(axis=0)[[4, 7]].min() > 0.01, "the arms do not move"
print(f"{len(directions)} frames, numpy {np.__version__}")
