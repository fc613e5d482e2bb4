"""The recording for the search: read as a stream with bounded memory, and treated if it is hard to align."""

from collections.abc import Sequence
from typing import BinaryIO

import numpy as np

RATE = 16000
_BLOCK = 10 * RATE
_MEMORY_SECONDS = 240.0
"""Seconds that are kept."""
_WINDOW = 512


class SoundStream:
    """A stream of ``samples`` int16 samples at 16 kHz, of which only the last minutes are kept."""

    def __init__(self, stream: BinaryIO, samples: int):
        self._stream, self._samples = stream, samples
        self._blocks: dict[int, np.ndarray] = {}
        self._read = 0

    @property
    def duration(self) -> float:
        """Duration in seconds."""
        return self._samples / RATE

    def count(self, start: float, end: float) -> int:
        """Return the number of samples between two times in seconds."""
        return max(min(int(end * RATE), self._samples) - max(int(start * RATE), 0), 0)

    def cut(self, start: float, end: float) -> np.ndarray:
        """Return the samples ``(n,)`` int16 between two times in seconds; those no longer kept are silence."""
        first, last = max(int(start * RATE), 0), min(int(end * RATE), self._samples)
        if last <= first:
            return np.zeros(0, np.int16)
        while self._read * _BLOCK < last:
            self._next()
        numbers = range(first // _BLOCK, (last - 1) // _BLOCK + 1)
        joined = np.concatenate([self._blocks.get(number, _SILENCE) for number in numbers])
        return joined[first - numbers[0] * _BLOCK : last - numbers[0] * _BLOCK]

    def _next(self) -> None:
        """Read the next block and discard the oldest."""
        size = min(_BLOCK, self._samples - self._read * _BLOCK)
        data = self._stream.read(2 * size)
        if len(data) < 2 * size:
            raise EOFError("the sound ended early")
        self._blocks[self._read] = np.frombuffer(data, "<i2")
        self._blocks.pop(self._read - int(_MEMORY_SECONDS * RATE / _BLOCK), None)
        self._read += 1


_SILENCE = np.zeros(_BLOCK, np.int16)


def preprocess(sound: np.ndarray, treatment: str, pauses: Sequence[tuple[float, float]]) -> np.ndarray:
    """Return the sound ``(n,)`` int16 ``plain``, with ``hiss`` or ``denoised``; ``pauses`` are in seconds of this sound."""
    if treatment == "hiss":
        sound = sound + np.random.default_rng(0).normal(0, 60, len(sound))
    elif treatment == "denoised":
        sound = denoise(sound, pauses)
    return np.clip(sound, -32768, 32767).astype("<i2")


def denoise(sound: np.ndarray, pauses: Sequence[tuple[float, float]]) -> np.ndarray:
    """Apply a Wiener filter against the mean spectrum of the pauses (in seconds); return ``(n,)`` float.

    The sound is returned unchanged if the pauses are too short."""
    hop = _WINDOW // 4
    padded = np.pad(sound.astype(np.float32), (_WINDOW, _WINDOW + -len(sound) % hop))
    window = np.sqrt(np.hanning(_WINDOW + 1)[:-1]).astype(np.float32)
    spectra = np.fft.rfft(np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::hop] * window, axis=1)
    centres = (np.arange(len(spectra)) * hop - _WINDOW / 2) / RATE
    silent = np.zeros(len(spectra), bool)
    for start, end in pauses:
        silent |= (centres > start + 0.05) & (centres < end - 0.05)
    if silent.sum() < 20:
        return sound
    power = np.abs(spectra) ** 2
    noise = power[silent].mean(0)
    around = np.pad(power, 1, mode="edge")
    around = sum(around[i : i + power.shape[0], j : j + power.shape[1]] for i in range(3) for j in range(3)) / 9
    weight = np.sqrt(np.maximum(1 - 1.5 * noise / np.maximum(around, 1e-9), 0.01))
    pieces = np.fft.irfft(spectra * weight, axis=1) * window / 2
    result = np.zeros(len(padded))
    for shift in range(4):
        part = pieces[shift::4].ravel()
        result[shift * hop : shift * hop + len(part)] += part
    return result[_WINDOW : _WINDOW + len(sound)]
