"""Store the golden motions and keys anew: ``python tests/golden/remake.py``, after a change that is meant to be seen.

Needs Blender's module for the keys, and the material folder beside the project for the second voice.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

import golden  # noqa: E402
import golden_keys  # noqa: E402


def main() -> None:
    """Write ``motions.npz``, ``take.npz`` and ``keys.npz`` beside this file."""
    shared = Path(__file__).resolve().parents[3] / "shared" / "data"
    packed, first = {}, None
    for name, step, motion in golden.perform(shared):
        first = first or motion
        packed |= golden.pack({f"{name}:{part}": values for part, values in golden.sampled(motion, step).items()})
        packed[f"{name}:meta"] = np.array(golden.described(motion))
    np.savez_compressed(golden.MOTIONS, **packed)
    first.save(golden.TAKE)
    np.savez_compressed(golden.KEYS, **golden_keys.pack_all())


if __name__ == "__main__":
    main()
