"""Reading LMDB's file (``data.mdb``, format 1) without its library, whose memory a damaged file would reach (lmdb.h, mdb.c)."""

import mmap
import struct
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

_MAGIC, _VERSION = 0xBEEFC0DE, 1
_BRANCH, _LEAF, _OVERFLOW = 0x01, 0x02, 0x04
_BIG = 0x01
_HEAD = 16
"""Bytes of a page's head: number, padding, flags, and the free space or the count of pages that follow."""
_NOWHERE = 2**64 - 1
_DEEPEST = 32


def records(folder: str | PathLike) -> Iterator[tuple[bytes, bytes]]:
    """Key and value of every record, in the order of the keys; raises ``ValueError`` or ``OSError``."""
    with open(Path(folder) / "data.mdb", "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        try:
            size, root = _newest(data)
            if root != _NOWHERE:
                yield from _Tree(data, size).walk(root, 0)
        except struct.error as error:
            raise ValueError(f"it is cut ({error})") from error


def _newest(data: mmap.mmap) -> tuple[int, int]:
    """Size of a page and the root of the newer of the two states."""
    (size,) = struct.unpack_from("<I", data, _HEAD + 24)
    if not (256 <= size <= 65536 and size & (size - 1) == 0):
        raise ValueError("it is no LMDB file")
    states = []
    for place in (_HEAD, size + _HEAD):
        magic, version = struct.unpack_from("<II", data, place)
        if (magic, version) != (_MAGIC, _VERSION):
            raise ValueError("it is no LMDB file")
        (root,) = struct.unpack_from("<Q", data, place + 24 + 48 + 40)
        states.append((struct.unpack_from("<Q", data, place + 24 + 96 + 8)[0], root))
    return size, max(states)[1]


class _Tree:
    def __init__(self, data: mmap.mmap, size: int):
        self.data, self.size, self.left = data, size, len(data) // size  # pages that may still be seen: no two ways lead to one

    def walk(self, number: int, depth: int) -> Iterator[tuple[bytes, bytes]]:
        """Records of a page and of those below it."""
        place = self._page(number)
        flags, lower = struct.unpack_from("<HH", self.data, place + 10)
        if depth > _DEEPEST or not flags & (_BRANCH | _LEAF) or not _HEAD <= lower <= self.size:
            raise ValueError(f"page {number} is damaged")
        room = self.size - lower  # records lie apart: a page would else give more than the whole file holds
        for row in range((lower - _HEAD) // 2):
            (offset,) = struct.unpack_from("<H", self.data, place + _HEAD + 2 * row)
            if not _HEAD <= offset <= self.size - 8:
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
            yield key, self._big(begin + length, count) if kind & _BIG else self._here(begin + length, count, place)

    def _here(self, begin: int, count: int, place: int) -> bytes:
        if begin + count > place + self.size:
            raise ValueError("a record is longer than its page")
        return self.data[begin : begin + count]

    def _big(self, place: int, count: int) -> bytes:
        begin = self._page(struct.unpack_from("<Q", self.data, place)[0])
        flags, pages = struct.unpack_from("<HI", self.data, begin + 10)
        if not flags & _OVERFLOW or not count <= pages * self.size - _HEAD or begin + pages * self.size > len(self.data):
            raise ValueError("a record is cut")
        self.left -= pages - 1
        if self.left < 0:
            raise ValueError("a record is used twice")
        return self.data[begin + _HEAD : begin + _HEAD + count]

    def _page(self, number: int) -> int:
        self.left -= 1
        if number * self.size + self.size > len(self.data) or self.left < 0:
            raise ValueError(f"page {number} lies outside or is used twice")
        return number * self.size
