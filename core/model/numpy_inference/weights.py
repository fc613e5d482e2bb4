"""A reader of safetensors files: eight bytes of header length, a JSON header, then raw arrays. Nothing is executed."""

import math
from os import PathLike
from pathlib import Path

import numpy as np

from ... import json_text

MAX_HEADER_BYTES = 1_000_000
"""Largest accepted header in bytes; the shipped one has 17,000."""
_DTYPES = {"F16": "<f2", "F32": "<f4"}


def read(path: str | PathLike) -> tuple[bytes, dict[str, np.ndarray]]:
    """Return the file's bytes, and its arrays by name as float32.

    Raises OSError, and ValueError unless it is a complete file of half or single precision numbers."""
    data = Path(path).read_bytes()
    length = int.from_bytes(data[:8], "little")
    if len(data) < 8 or length > min(MAX_HEADER_BYTES, len(data) - 8):
        raise ValueError("it is no safetensors file, or cut off")
    try:
        header = json_text.parse(data[8 : 8 + length], MAX_HEADER_BYTES)
        entries = {name: _entry(**entry) for name, entry in header.items() if name != "__metadata__"}
    except (TypeError, AttributeError, json_text.NotJson) as error:
        raise ValueError("its header makes no sense") from error
    body = memoryview(data)[8 + length :]
    places = sorted((begin, end) for _, _, begin, end in entries.values())
    if any(begin < end for (_, end), (begin, _) in zip(places, places[1:], strict=False)):
        raise ValueError("its arrays overlap")
    arrays = {}
    for name, (kind, shape, begin, end) in entries.items():
        if end > len(body):
            raise ValueError(f"{name} lies beyond its end")
        arrays[name] = np.frombuffer(body[begin:end], kind).reshape(shape).astype(np.float32)
    return data, arrays


def _entry(dtype: str, shape: list, data_offsets: list) -> tuple[np.dtype, tuple, int, int]:
    """Return dtype, shape, begin and end of an array."""
    if dtype not in _DTYPES:
        raise ValueError(f"numbers of kind {dtype!r} are not read")
    begin, end = data_offsets
    if any(type(number) is not int or number < 0 for number in (*shape, begin, end)):
        raise ValueError("a size is no whole number")
    kind = np.dtype(_DTYPES[dtype])
    if begin > end or end - begin != math.prod(shape) * kind.itemsize:
        raise ValueError("an array is not as large as it says")
    return kind, tuple(shape), begin, end
