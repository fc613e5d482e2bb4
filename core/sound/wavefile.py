"""Reads WAV files with numpy: PCM of 8 to 32 bits, floats of 32 and 64 bits, with or without the extensible header.

The format is RIFF WAVE (Microsoft and IBM, "Multimedia Programming Interface and Data Specifications 1.0", 1991). A data
size that the writing program did not know yet means "to the end of the file"."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..files import open_file

_UNKNOWN_SIZE = 0x7FFFFFFF
"""Programs that do not know the data size yet write 0 or a value from here on."""
_PIECE_SAMPLES = 1 << 18
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_FORMATS = {(_PCM, 8): "u1", (_PCM, 16): "<i2", (_PCM, 24): "", (_PCM, 32): "<i4", (_FLOAT, 32): "<f4", (_FLOAT, 64): "<f8"}


@dataclass(frozen=True)
class Header:
    """Format and position of the samples in a WAV file.

    ``kind`` is the numpy dtype of a sample ("" for 24 bits, None for an unsupported format), ``rate`` the samples per second,
    ``begin`` the byte offset of the first sample, ``there`` the data bytes in the file, ``promised`` those in the header."""

    kind: str | None
    rate: int
    channels: int
    begin: int
    there: int
    declared_bytes: int

    @property
    def share(self) -> float:
        """Return the fraction 0..1 of the declared data that the file contains."""
        return self.there / self.declared_bytes if 0 < self.there < self.declared_bytes else 1.0


def read_header(path: Path) -> Header | None:
    """Return the header of a RIFF WAVE file; None for any other file, or if the format or data chunk is missing."""
    layout = None
    with open_file(path) as file:
        riff, _, wave = struct.unpack("<4sI4s", file.read(12).ljust(12))
        while riff == b"RIFF" and wave == b"WAVE" and len(head := file.read(8)) == 8:
            name, size = struct.unpack("<4sI", head)
            begin = file.tell()
            if name == b"fmt ":
                layout = _layout(file.read(min(size, 40)))
            elif name == b"data" and layout:
                available = path.stat().st_size - begin
                known_size = 0 < size < _UNKNOWN_SIZE
                return Header(
                    *layout, begin, min(available, size) if known_size else available, size if known_size else available
                )
            file.seek(begin + size + size % 2)
    return None


def read_samples(path: Path, head: Header) -> Iterator[np.ndarray]:
    """Yield the samples as ``(channels, n)`` float32 pieces, full scale 1; the header's ``kind`` must not be None."""
    assert head.kind is not None
    width = np.dtype(head.kind or "V3").itemsize
    left = head.there // (width * head.channels)
    with open(path, "rb") as file:
        file.seek(head.begin)
        while left:
            count = min(left, max(_PIECE_SAMPLES // head.channels, 1))
            data = file.read(count * width * head.channels)
            yield _to_float(data, head.kind).reshape(-1, head.channels).T
            left -= count


def _layout(form: bytes) -> tuple[str | None, int, int] | None:
    """Return kind, rate and channels of a ``fmt`` chunk, or None if it is invalid."""
    if len(form) < 16:
        return None
    tag, channels, rate, _, block, bits = struct.unpack("<HHIIHH", form[:16])
    if tag == _EXTENSIBLE and len(form) >= 26:
        tag = struct.unpack("<H", form[24:26])[0]
    if not channels or not rate or not block:
        return None
    return _FORMATS.get((tag, 8 * (block // channels) if tag in (_PCM, _FLOAT) else bits)), rate, channels


def _to_float(data: bytes, kind: str) -> np.ndarray:
    """Convert raw sample bytes to ``(n,)`` float32 from -1 to 1."""
    if not kind:
        wide = np.zeros((len(data) // 3, 4), np.uint8)
        wide[:, 1:] = np.frombuffer(data, np.uint8).reshape(-1, 3)
        data, kind = wide.tobytes(), "<i4"
    values = np.frombuffer(data, kind)
    if kind == "u1":
        return (values.astype(np.float32) - 128) / np.float32(128)
    if kind[1] == "f":
        return values.astype(np.float32)
    return (values / np.float32(-float(np.iinfo(kind).min))).astype(np.float32)
