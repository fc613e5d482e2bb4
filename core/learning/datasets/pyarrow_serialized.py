"""Reads the output of ``pyarrow.serialize`` without it: releases 0.14 to 13 write three dialects, and read only their own.

A record is four counts, a stream of Arrow messages (a schema and one batch: a tree of unions with all values) and a message
for each array (Arrow's Message.fbs, Schema.fbs and Tensor.fbs). Nothing is executed: pickled objects are refused.
"""

import struct
from collections.abc import Iterator

import numpy as np

from .flatbuffer import Table

_SCHEMA, _BATCH, _TENSOR = 1, 3, 4
_INT, _FLOAT, _BINARY, _TEXT, _BOOL, _LIST, _STRUCT, _UNION = 2, 3, 4, 5, 6, 12, 13, 14
_UNIONS_WITHOUT_NULLS = 4
"""The metadata version (of release 1.0) from which unions have no validity bits, but a kind of value for nulls."""
BOOL, INT, BYTES, STRING, HALF, FLOAT, DOUBLE, LIST, DICT, TUPLE, ARRAY = 0, 1, 3, 4, 5, 6, 7, 9, 10, 11, 14
NONE = -1
_NUMBERS = (INT, HALF, FLOAT, DOUBLE)
_MAX_DEPTH = 40
"""Most levels of nested types; pyarrow itself stops at a hundred."""
_NODE_BYTES = 12
"""Least bytes of a node of the schema."""
_MAX_AXES = 32


def read(data: bytes, unwanted: tuple[str, ...] = ()) -> object:
    """Return the object in a record: dictionaries without the keys ``unwanted``, lists, numbers, texts and arrays.

    Lists of numbers of equal length may be returned as arrays. Raises ``ValueError`` for damaged records and other kinds of
    objects.
    """
    try:
        return _record(data, unwanted)
    except (struct.error, IndexError, OverflowError, RecursionError, StopIteration) as error:
        raise ValueError(f"it is cut or damaged ({error})") from error


def _record(data: bytes, unwanted: tuple[str, ...]) -> object:
    tensors, *counts, last = struct.unpack_from("<4i", data)
    if tensors or last or min(counts) != 0 or max(counts) > len(data):  # since 0.16 sparse tensors precede the arrays
        raise ValueError("it holds tensors or buffers")
    messages = _messages(data, 16)
    kind, schema, _, version = next(messages)
    if kind != _SCHEMA:
        raise ValueError("it begins with no schema")
    nodes = _Budget(len(data) // _NODE_BYTES)
    fields = [_Field(one, 0, nodes) for one in schema.tables(1)]
    kind, batch, body, _ = next(messages)
    if kind != _BATCH or len(fields) != 1:
        raise ValueError("it holds no batch of one column")
    reader = _Reader(data, batch, body, version >= _UNIONS_WITHOUT_NULLS, unwanted)
    root = reader.column(fields[0])
    if not isinstance(root, (_Union, _Text)):
        raise ValueError("it holds no batch of one column")
    reader.arrays = list(_arrays(data, messages, max(counts)))
    return root.value(0)


class _Budget:
    """A limit on what is read, against records that refer to the same values again and again."""

    def __init__(self, left: int):
        self.left = left

    def spend(self, count: int) -> None:
        """Subtract ``count``; raises ``ValueError`` if too little is left."""
        self.left -= count
        if self.left < 0:
            raise ValueError("it refers to the same values again and again")


def _messages(data: bytes, place: int) -> Iterator[tuple[int, Table, int, int]]:
    """Yield kind, header, body offset and version of every message; those of arrays are aligned to 64 bytes."""
    while True:
        length = struct.unpack_from("<I", data, place)[0]
        place += 4
        if length == 0xFFFFFFFF:  # since 0.15
            length = struct.unpack_from("<I", data, place)[0]
            place += 4
        if not length:
            place = -(-place // 64) * 64
            continue
        message = Table(data, place + struct.unpack_from("<I", data, place)[0])
        body, size = place + length, message.number(3, "q")
        if not 0 <= size <= len(data) - body:
            raise ValueError("a message is longer than the record")
        kind = message.number(1, "B")
        yield kind, message.table(2), body, message.number(0, "h")
        place = body + size
        if kind == _TENSOR:
            place = -(-place // 64) * 64


def _arrays(data: bytes, messages: Iterator[tuple[int, Table, int, int]], count: int) -> Iterator[np.ndarray]:
    for _ in range(count):
        kind, tensor, body, _ = next(messages)
        if kind != _TENSOR:
            raise ValueError("an array is missing")
        dtype = _dtype(tensor.number(0, "B"), tensor.table(1))
        shape = [one.number(0, "q") for one in tensor.tables(2)]
        place = tensor.at(4)
        offset, size = struct.unpack_from("<qq", data, place) if place else (0, 0)
        flat = _view(data, body + offset, size, dtype)
        if len(shape) > _MAX_AXES or any(side < 0 for side in shape) or flat.size < np.prod(shape, dtype=object):
            raise ValueError("an array is cut")
        strides = [one for (one,) in tensor.items(3, "q")]
        rows = [int(np.prod(shape[axis + 1 :], dtype=object)) * dtype.itemsize for axis in range(len(shape))]
        if strides and flat.size and all(shape) and strides != rows:
            raise ValueError("an array lies in another order than rows")
        yield flat[: int(np.prod(shape, dtype=object))].reshape(shape)


def _view(data: bytes, place: int, size: int, dtype: np.dtype) -> np.ndarray:
    if not (0 <= place <= len(data) and 0 <= size <= len(data) - place):
        raise ValueError("a buffer lies outside")
    return np.frombuffer(data, dtype, size // dtype.itemsize, place) if size >= dtype.itemsize else np.zeros(0, dtype)


def _dtype(kind: int, facts: Table) -> np.dtype:
    if kind == _INT and facts.number(0, "i") in (8, 16, 32, 64):
        return np.dtype(f"<{'i' if facts.number(1, 'B') else 'u'}{facts.number(0, 'i') // 8}")
    if kind == _FLOAT and facts.number(0, "h") in (0, 1, 2):
        return np.dtype(("<f2", "<f4", "<f8")[facts.number(0, "h")])
    raise ValueError(f"numbers of kind {kind} are not read")


class _Field:
    """A node of the schema."""

    def __init__(self, table: Table, depth: int, nodes: _Budget):
        nodes.spend(1)
        if depth > _MAX_DEPTH:
            raise ValueError("it is nested too deeply")
        self.name, self.kind, self.facts = table.text(0), table.number(2, "B"), table.table(3)
        self.children = [_Field(one, depth + 1, nodes) for one in table.tables(5)]


class _Reader:
    """Assigns the buffers of the batch to columns, in the order of the schema."""

    def __init__(self, data: bytes, batch: Table, body: int, later: bool, unwanted: tuple[str, ...]):
        self.data, self.body, self.later, self.unwanted = data, body, later, unwanted
        self.nodes, self.buffers = iter(batch.items(1, "qq")), iter(batch.items(2, "qq"))
        self.arrays: list[np.ndarray] = []
        self.values = _Budget(len(data))  # each value takes at least a byte, as does each letter
        self._room = _Budget(len(data))  # buffers do not overlap

    def buffer(self, dtype: str) -> np.ndarray:
        offset, size = next(self.buffers)
        self._room.spend(max(size, 0))
        return _view(self.data, self.body + offset, size, np.dtype(dtype))

    def bits(self) -> np.ndarray:
        return np.unpackbits(self.buffer("u1"), bitorder="little")

    def column(self, field: _Field) -> "_Column":
        """Return the column of a field, with those below it."""
        count, nulls = next(self.nodes)
        if not 0 <= count <= len(self.data):
            raise ValueError("a column is longer than the record")
        if field.kind == _UNION:
            return _Union(self, field, nulls)
        if field.kind == 1:  # null: no buffers
            return None
        self.buffer("u1")  # validity bits, which unions have of their own
        if field.kind in (_BINARY, _TEXT):
            return _Text(self.buffer("<i4"), self.buffer("u1"), field.kind == _TEXT)
        if field.kind == _BOOL:
            return self.bits().astype(bool)
        if field.kind == _LIST and len(field.children) == 1:
            return _List(self.buffer("<i4"), self.column(field.children[0]))
        if field.kind == _STRUCT and len(field.children) == 2:
            return [self.column(one) for one in field.children]
        return self.buffer(_dtype(field.kind, field.facts).str)


class _Text:
    def __init__(self, edges: np.ndarray, letters: np.ndarray, text: bool):
        self.edges, self.letters, self.text = edges, letters, text

    def value(self, row: int) -> str | bytes:
        begin, end = _span(self.edges, row, len(self.letters))
        data = self.letters[begin:end].tobytes()
        return data.decode() if self.text else data


class _List:
    def __init__(self, edges: np.ndarray, inner: "_Column"):
        self.edges, self.inner = edges, inner

    def span(self, row: int) -> tuple[int, int]:
        """Return the first item of a list, and the one after its last."""
        return _span(self.edges, row, np.iinfo(np.int32).max)


def _span(edges: np.ndarray, row: int, limit: int) -> tuple[int, int]:
    if not 0 <= row < len(edges) - 1:
        raise ValueError("a list lies outside")
    begin, end = int(edges[row]), int(edges[row + 1])
    if not 0 <= begin <= end <= limit:
        raise ValueError("a list ends before it begins")
    return begin, end


class _Union:
    """A column of values of several kinds: each has a kind, and a row in the column of that kind."""

    def __init__(self, reader: _Reader, field: _Field, nulls: int):
        self.reader = reader
        bits = np.zeros(0, np.uint8) if reader.later else reader.bits()
        self.valid = bits if nulls else None
        self.types, self.rows = reader.buffer("i1"), reader.buffer("<i4")
        if field.facts.number(0, "h") != 1:
            raise ValueError("its unions are not dense")
        self.children: list[tuple[int, _Column]] = []
        for child in field.children:
            if not (child.name.isdecimal() and len(child.name) < 4):
                raise ValueError("a kind has no number")
            self.children.append((int(child.name) - reader.later, reader.column(child)))

    def value(self, at: int) -> object:
        """Return the value at a row."""
        if not 0 <= at < min(len(self.types), len(self.rows)):
            raise ValueError("a value lies outside")
        self.reader.values.spend(1)
        if self.valid is not None and not self.valid[at]:
            return None
        kind, column = self.children[self.types[at]] if self.types[at] >= 0 else (99, None)
        row = int(self.rows[at])
        if kind == NONE:
            return None
        if kind in (LIST, TUPLE):
            return self._list(column, row)
        if kind == DICT:
            return self._dictionary(column, row)
        if kind in (BYTES, STRING) and isinstance(column, _Text):
            text = column.value(row)
            self.reader.values.spend(len(text))
            return text
        if kind in (BOOL, *_NUMBERS, ARRAY) and isinstance(column, np.ndarray) and 0 <= row < len(column):
            return column[row].item() if kind != ARRAY else self._array(int(column[row]))
        raise ValueError(f"objects of kind {kind} are not read")

    def _array(self, number: int) -> np.ndarray:
        if not 0 <= number < len(self.reader.arrays):
            raise ValueError("an array is missing")
        self.reader.values.spend(self.reader.arrays[number].nbytes)
        return self.reader.arrays[number]

    def _list(self, column: "_Column", row: int) -> list | np.ndarray:
        if not (isinstance(column, _List) and isinstance(column.inner, _Union)):
            raise ValueError("a list holds no values")
        begin, end = column.span(row)
        numbers = column.inner.regular(begin, end)
        return [column.inner.value(at) for at in range(begin, end)] if numbers is None else numbers

    def regular(self, begin: int, end: int) -> np.ndarray | None:
        """Return the values as one array, if they are consecutive numbers of one kind, or lists of equal length of such."""
        types, rows = self.types[begin:end], self.rows[begin:end]
        if not 0 < len(rows) == len(types) == end - begin or (types != types[0]).any():
            return None
        if self.valid is not None and not self.valid[begin:end].all():
            return None
        kind, column = self.children[types[0]] if types[0] >= 0 else (99, None)
        first = int(rows[0])
        if first < 0 or (np.diff(rows) != 1).any():
            return None
        if kind in _NUMBERS and isinstance(column, np.ndarray) and first + len(rows) <= len(column):
            self.reader.values.spend(len(rows))
            return column[first : first + len(rows)]
        if kind != LIST or not isinstance(column, _List) or not isinstance(column.inner, _Union):
            return None
        edges = column.edges[first : first + len(rows) + 1]
        if len(edges) != len(rows) + 1 or edges[0] < 0 or edges[1] <= edges[0] or (np.diff(edges) != edges[1] - edges[0]).any():
            return None
        inner = column.inner.regular(int(edges[0]), int(edges[-1]))
        return None if inner is None else inner.reshape(len(rows), -1, *inner.shape[1:])

    def _dictionary(self, column: "_Column", row: int) -> dict[str, object]:
        if not (isinstance(column, _List) and isinstance(column.inner, list)):
            raise ValueError("a dictionary holds no pairs")
        keys, values = column.inner
        if not (isinstance(keys, _Union) and isinstance(values, _Union)):
            raise ValueError("a dictionary holds no pairs")
        result: dict[str, object] = {}
        for at in range(*column.span(row)):
            key = keys.value(at)
            if key == "_pytype_":
                raise ValueError("it holds a pickled object")
            if isinstance(key, str) and key not in self.reader.unwanted:
                result[key] = values.value(at)
        return result


_Column = _Union | _Text | _List | np.ndarray | list | None
