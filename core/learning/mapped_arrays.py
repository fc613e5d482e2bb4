"""Arrays of data sets that stay on the disk."""

from os import PathLike

import numpy as np

from ..files import open_file


def map_array(path: str | PathLike) -> np.ndarray:
    """Return the array of a ``.npy`` file, memory-mapped for reading. Raises OSError and errors of damaged files."""
    open_file(path).close()  # readers that open files by themselves would wait for a pipe
    return np.load(path, mmap_mode="r", allow_pickle=False)
