"""WAV files read by numpy: PCM of 8 to 32 bits and floats of 32 and 64, in RIFF, with or without the extensible header.

The layout is that of Microsoft's and IBM's "Multimedia Programming Interface and Data Specifications 1.0" (1991); sizes
that a program did not know when it wrote the header are taken as "to the end of the file".
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

_STREAMED = 0x7FFFFFFF
"""Sizes from here on, and 0, are what programs write that do not know the size yet."""
_PIECE = 1 << 18
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_FORMATS = {(_PCM, 8): "u1", (_PCM, 16): "<i2", (_PCM, 24): "", (_PCM, 32): "<i4", (_FLOAT, 32): "<f4", (_FLOAT, 64): "<f8"}


@dataclass(frozen=True)
class Header:
    """``kind`` (numpy's name of a sample; "" for 24 bits, None for what this module cannot read), samples a second ``rate``,
    ``channels``, ``begin`` of the samples in bytes, bytes ``there`` and ``promised``."""

    kind: str | None
    rate: int
    channels: int
    begin: int
    there: int
    promised: int

    @property
    def share(self) -> float:
        """How much of what the header promises is there."""
        return self.there / self.promised if 0 < self.there < self.promised else 1.0


def header(path: Path) -> Header | None:
    """The header of a RIFF WAVE file; None for any other file and for one without samples' form or place."""
    layout = None
    with open(path, "rb") as file:
        riff, _, wave = struct.unpack("<4sI4s", file.read(12).ljust(12))
        while riff == b"RIFF" and wave == b"WAVE" and len(head := file.read(8)) == 8:
            name, size = struct.unpack("<4sI", head)
            begin = file.tell()
            if name == b"fmt ":
                layout = _layout(file.read(min(size, 40)))
            elif name == b"data" and layout:
                there = path.stat().st_size - begin
                known = 0 < size < _STREAMED
                return Header(*layout, begin, min(there, size) if known else there, size if known else there)
            file.seek(begin + size + size % 2)
    return None


def samples(path: Path, head: Header) -> Iterator[np.ndarray]:
    """``(channels, n)`` float32 pieces, full scale 1, of a file whose header has a ``kind``."""
    width = np.dtype(head.kind or "V3").itemsize
    left = head.there // (width * head.channels)
    with open(path, "rb") as file:
        file.seek(head.begin)
        while left:
            count = min(left, max(_PIECE // head.channels, 1))
            data = file.read(count * width * head.channels)
            yield _scaled(data, head.kind).reshape(-1, head.channels).T
            left -= count


def _layout(form: bytes) -> tuple[str | None, int, int] | None:
    """Kind, rate and channels of a ``fmt`` chunk; None where it is nonsense."""
    if len(form) < 16:
        return None
    tag, channels, rate, _, block, bits = struct.unpack("<HHIIHH", form[:16])
    if tag == _EXTENSIBLE and len(form) >= 26:
        tag = struct.unpack("<H", form[24:26])[0]
    if not channels or not rate or not block:
        return None
    return _FORMATS.get((tag, 8 * (block // channels) if tag in (_PCM, _FLOAT) else bits)), rate, channels


def _scaled(data: bytes, kind: str) -> np.ndarray:
    """``(n,)`` float32 from -1 to 1."""
    if not kind:
        wide = np.zeros((len(data) // 3, 4), np.uint8)
        wide[:, 1:] = np.frombuffer(data, np.uint8).reshape(-1, 3)
        data, kind = wide.tobytes(), "<i4"
    found = np.frombuffer(data, kind)
    if kind == "u1":
        return (found.astype(np.float32) - 128) / np.float32(128)
    if kind[1] == "f":
        return found.astype(np.float32)
    return (found / np.float32(-float(np.iinfo(kind).min))).astype(np.float32)
