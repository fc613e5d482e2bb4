"""Reads LMDB files (``data.mdb``, format 1) without the library, in which damaged files corrupt memory (lmdb.h, mdb.c)."""

import mmap
import struct
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

from ...files import open_file

_MAGIC, _VERSION = 0xBEEFC0DE, 1
_BRANCH, _LEAF, _OVERFLOW = 0x01, 0x02, 0x04
_BIG = 0x01
_HEADER = 16
"""Bytes of a page's header: number, padding, flags, and the free space or the count of overflow pages."""
_NO_PAGE = 2**64 - 1
_MAX_DEPTH = 32


def records(folder: str | PathLike) -> Iterator[tuple[bytes, bytes]]:
    """Yield key and value of every record, in the order of keys; raises ``ValueError`` or ``OSError``."""
    with open_file(Path(folder) / "data.mdb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        try:
            size, root = _newest_root(data)
            if root != _NO_PAGE:
                yield from _Tree(data, size).walk(root, 0)
        except struct.error as error:
            raise ValueError(f"it is cut ({error})") from error


def _newest_root(data: mmap.mmap) -> tuple[int, int]:
    """Return the size of a page, and the root page of the newer of the two meta pages."""
    (size,) = struct.unpack_from("<I", data, _HEADER + 24)
    if not (256 <= size <= 65536 and size & (size - 1) == 0):
        raise ValueError("it is no LMDB file")
    states = []
    for place in (_HEADER, size + _HEADER):
        magic, version = struct.unpack_from("<II", data, place)
        if (magic, version) != (_MAGIC, _VERSION):
            raise ValueError("it is no LMDB file")
        (root,) = struct.unpack_from("<Q", data, place + 24 + 48 + 40)
        states.append((struct.unpack_from("<Q", data, place + 24 + 96 + 8)[0], root))
    return size, max(states)[1]


class _Tree:
    """The B+ tree of a file; it raises ``ValueError`` for pages outside the file or used twice."""

    def __init__(self, data: mmap.mmap, size: int):
        self.data, self.size = data, size
        self.left = len(data) // size  # pages that may still be read, as none belongs to two parents

    def walk(self, number: int, depth: int) -> Iterator[tuple[bytes, bytes]]:
        """Yield the records of a page and of those below it."""
        place = self._page(number)
        flags, lower = struct.unpack_from("<HH", self.data, place + 10)
        if depth > _MAX_DEPTH or not flags & (_BRANCH | _LEAF) or not _HEADER <= lower <= self.size:
            raise ValueError(f"page {number} is damaged")
        room = self.size - lower  # records must not overlap, or a small file could yield endless data
        for row in range((lower - _HEADER) // 2):
            (offset,) = struct.unpack_from("<H", self.data, place + _HEADER + 2 * row)
            if not _HEADER <= offset <= self.size - 8:
                raise ValueError(f"page {number} is damaged")
            low, high, kind, length = struct.unpack_from("<4H", self.data, place + offset)
            begin = place + offset + 8
            room -= 8 + length + (0 if flags & _BRANCH or kind & _BIG else low | high << 16)
            if room < 0:
                raise ValueError(f"page {number} holds the same records again and again")
            if flags & _BRANCH:
                yield from self.walk(low | high << 16 | kind << 32, depth + 1)
                continue
            if kind & ~_BIG or offset + 8 + length > self.size:
                raise ValueError(f"page {number} holds records of another kind")
            key, count = self.data[begin : begin + length], low | high << 16
            yield key, self._overflow_value(begin + length, count) if kind & _BIG else self._value(begin + length, count, place)

    def _value(self, begin: int, count: int, place: int) -> bytes:
        if begin + count > place + self.size:
            raise ValueError("a record is longer than its page")
        return self.data[begin : begin + count]

    def _overflow_value(self, place: int, count: int) -> bytes:
        begin = self._page(struct.unpack_from("<Q", self.data, place)[0])
        flags, pages = struct.unpack_from("<HI", self.data, begin + 10)
        if not flags & _OVERFLOW or not count <= pages * self.size - _HEADER or begin + pages * self.size > len(self.data):
            raise ValueError("a record is cut")
        self.left -= pages - 1
        if self.left < 0:
            raise ValueError("a record is used twice")
        return self.data[begin + _HEADER : begin + _HEADER + count]

    def _page(self, number: int) -> int:
        """Return the offset of a page in the file."""
        self.left -= 1
        if number * self.size + self.size > len(self.data) or self.left < 0:
            raise ValueError(f"page {number} lies outside or is used twice")
        return number * self.size
