"""Reads the tables of a FlatBuffer, the encoding of Arrow's messages (FlatBuffers Internals)."""

import struct

_MAX_NAME = 100
"""Most bytes of a name."""


class Table:
    """A table of a FlatBuffer at an offset."""

    def __init__(self, data: bytes, place: int):
        self.data, self.place = data, place
        self._slots = place - struct.unpack_from("<i", data, place)[0]
        if not 0 <= self._slots < len(data):
            raise ValueError("a table lies outside")
        self._count = (struct.unpack_from("<H", data, self._slots)[0] - 4) // 2

    def at(self, slot: int) -> int:
        """Return the offset of a slot's value, or 0 if it is absent."""
        if slot >= self._count:
            return 0
        offset = struct.unpack_from("<H", self.data, self._slots + 4 + 2 * slot)[0]
        return self.place + offset if offset else 0

    def number(self, slot: int, code: str) -> int:
        """Return a number by its ``struct`` code, or 0 if it is absent."""
        place = self.at(slot)
        return struct.unpack_from(f"<{code}", self.data, place)[0] if place else 0

    def table(self, slot: int) -> "Table":
        """Return a required table; raises ``ValueError`` if it is absent."""
        place = self.at(slot)
        if not place:
            raise ValueError("a part is missing")
        return Table(self.data, place + struct.unpack_from("<I", self.data, place)[0])

    def vector(self, slot: int) -> tuple[int, int]:
        """Return the offset of a vector's items and their count."""
        place = self.at(slot)
        if not place:
            return 0, 0
        place += struct.unpack_from("<I", self.data, place)[0]
        count = struct.unpack_from("<I", self.data, place)[0]
        if count > len(self.data):
            raise ValueError("a list is longer than the record")
        return place + 4, count

    def tables(self, slot: int) -> list["Table"]:
        """Return the tables of a vector."""
        begin, count = self.vector(slot)
        places = range(begin, begin + 4 * count, 4)
        return [Table(self.data, place + struct.unpack_from("<I", self.data, place)[0]) for place in places]

    def items(self, slot: int, code: str) -> list[tuple[int, ...]]:
        """Return the structs of a vector."""
        begin, count = self.vector(slot)
        size = struct.calcsize(f"<{code}")
        return [struct.unpack_from(f"<{code}", self.data, begin + size * row) for row in range(count)]

    def text(self, slot: int) -> str:
        """Return a name, empty if it is absent."""
        begin, count = self.vector(slot)
        if count > _MAX_NAME:
            raise ValueError("a name is too long")
        return bytes(self.data[begin : begin + count]).decode()
