"""Arrays of data sets that stay on the disk."""

from os import PathLike

import numpy as np

from ..files import check_input


def map_array(path: str | PathLike) -> np.ndarray:
    """Return the array of a ``.npy`` file, memory-mapped for reading. Raises OSError and errors of damaged files."""
    check_input(path)
    return np.load(path, mmap_mode="r", allow_pickle=False)
