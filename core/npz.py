"""Safe reader of untrusted ``.npz`` files: executes nothing, and checks sizes before memory is allocated."""

import contextlib
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from os import PathLike

import numpy as np

from .files import open_file

MAX_BYTES = 256_000_000
"""Bytes that all arrays of a motion may take unpacked; half a day takes 150 MB."""
DAMAGED = (ValueError, KeyError, IndexError, TypeError, AttributeError, OverflowError, EOFError, RuntimeError, SyntaxError)
DAMAGED += (MemoryError, zipfile.BadZipFile, zlib.error, tokenize.TokenError)
"""Exceptions of zipfile and numpy for damaged files."""
_KINDS = "biufSU"
"""Accepted kinds of dtypes: booleans, numbers, text."""


class NotArrays(ValueError):
    """The file holds no acceptable arrays."""


@contextlib.contextmanager
def open_arrays(path: str | PathLike, largest: int = MAX_BYTES) -> Iterator[Mapping[str, np.ndarray]]:
    """Open a file and yield its arrays by name, which may take ``largest`` bytes unpacked.

    Errors of the ``with`` block about invalid content (:class:`ValueError`, :class:`KeyError` and the like, see
    :data:`DAMAGED`) are raised as :class:`NotArrays`, too. Raises OSError."""
    try:
        with open_file(path) as file, zipfile.ZipFile(file) as packed:
            total = 0
            for member in packed.infolist():
                total += max(member.file_size, _declared_size(packed, member))
                if total > largest:
                    raise NotArrays(f"its arrays are larger than {largest // 1_000_000} MB")
        with np.load(path, allow_pickle=False) as data:
            yield data
    except NotArrays:
        raise
    except DAMAGED as error:
        raise NotArrays(" ".join(str(error).split())[:200] or type(error).__name__) from error


def _declared_size(packed: zipfile.ZipFile, member: zipfile.ZipInfo) -> int:
    """Return the array size in bytes that a member's header declares: numpy allocates it before reading."""
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
