"""What was learned on films of known motions: the file, by parts."""

from functools import cache
from pathlib import Path

import numpy as np

FILE = Path(__file__).with_name("weights.npz")


def of(part: str) -> dict[str, np.ndarray]:
    """Return the arrays of a part (``view``, ``lift``); empty where there is no file."""
    return {name.partition("/")[2]: value for name, value in _every().items() if name.startswith(f"{part}/")}


def forget() -> None:
    """Read the file anew."""
    _every.cache_clear()


@cache
def _every() -> dict[str, np.ndarray]:
    if not FILE.is_file():
        return {}
    with np.load(FILE, allow_pickle=False) as data:
        return {name: value.astype(float) for name, value in data.items()}
