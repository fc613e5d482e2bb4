"""Arrays of ``.npz`` files that others may have written: nothing in them runs, and their size is known before it is taken."""

import contextlib
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from os import PathLike

import numpy as np

LARGEST = 256_000_000
"""Bytes that all arrays of a performance may unpack to; half a day of one takes 150 MB."""
DAMAGED = (ValueError, KeyError, IndexError, TypeError, AttributeError, OverflowError, EOFError, RuntimeError, SyntaxError)
DAMAGED += (MemoryError, zipfile.BadZipFile, zlib.error, tokenize.TokenError)
"""What zipfile and numpy raise on damaged files, as they are."""


_KINDS = "biufSU"
"""Kinds of arrays that are read: truth values, numbers, text."""


class NotArrays(ValueError):
    """The file holds no arrays that are read here."""


@contextlib.contextmanager
def opened(path: str | PathLike, largest: int = LARGEST) -> Iterator[np.lib.npyio.NpzFile]:
    """The arrays of a file by name, which may unpack to ``largest`` bytes.

    What is raised inside over content that is not as it should be (:class:`ValueError`, :class:`KeyError` and their like)
    leaves as :class:`NotArrays`, too. Raises OSError.
    """
    try:
        with zipfile.ZipFile(path) as packed:
            total = 0
            for member in packed.infolist():
                total += max(member.file_size, _stated(packed, member))
                if total > largest:
                    raise NotArrays(f"its arrays are larger than {largest // 1_000_000} MB")
        with np.load(path, allow_pickle=False) as data:
            yield data
    except NotArrays:
        raise
    except DAMAGED as error:
        raise NotArrays(" ".join(str(error).split())[:200] or type(error).__name__) from error


def _stated(packed: zipfile.ZipFile, member: zipfile.ZipInfo) -> int:
    """Bytes of the array that a member's own header promises: numpy takes that much before it reads."""
    with packed.open(member) as file:
        version = np.lib.format.read_magic(file)
        header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, kind = header(file)
    if kind.kind not in _KINDS:
        raise NotArrays(f"it holds {kind}, where numbers or text belong")
    size = kind.itemsize
    for length in shape:
        size *= int(length)
    return size
