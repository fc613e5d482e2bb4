"""The recording as the search hears it: read as it comes, forgotten as it goes, and treated where it is hard to hear."""

from typing import BinaryIO

import numpy as np

RATE = 16000
_BLOCK = 10 * RATE
_MEMORY = 240.0
"""Seconds that can be gone back."""
_WINDOW = 512


class Sound:
    """int16 samples at 16 kHz from a stream of ``samples`` of them; only the last minutes are kept."""

    def __init__(self, stream: BinaryIO, samples: int):
        self._stream, self._samples = stream, samples
        self._blocks: dict[int, np.ndarray] = {}
        self._read = 0

    @property
    def duration(self) -> float:
        """Seconds."""
        return self._samples / RATE

    def count(self, start: float, end: float) -> int:
        """Samples between two moments."""
        return max(min(int(end * RATE), self._samples) - max(int(start * RATE), 0), 0)

    def cut(self, start: float, end: float) -> np.ndarray:
        """``(n,)`` int16 between two moments. What lies more than four minutes before the last moment asked for is silence."""
        first, last = max(int(start * RATE), 0), min(int(end * RATE), self._samples)
        if last <= first:
            return np.zeros(0, np.int16)
        while self._read * _BLOCK < last:
            self._next()
        numbers = range(first // _BLOCK, (last - 1) // _BLOCK + 1)
        joined = np.concatenate([self._blocks.get(number, _SILENCE) for number in numbers])
        return joined[first - numbers[0] * _BLOCK : last - numbers[0] * _BLOCK]

    def _next(self) -> None:
        size = min(_BLOCK, self._samples - self._read * _BLOCK)
        data = self._stream.read(2 * size)
        if len(data) < 2 * size:
            raise EOFError("the sound ended early")
        self._blocks[self._read] = np.frombuffer(data, "<i2")
        self._blocks.pop(self._read - int(_MEMORY * RATE / _BLOCK), None)
        self._read += 1


_SILENCE = np.zeros(_BLOCK, np.int16)


def treated(sound: np.ndarray, treatment: str, pauses: list) -> np.ndarray:
    """``(n,)`` int16 ``plain``, with ``hiss`` or ``denoised``; ``pauses`` in seconds of this sound."""
    if treatment == "hiss":
        sound = sound + np.random.default_rng(0).normal(0, 60, len(sound))
    elif treatment == "denoised":
        sound = denoise(sound, pauses)
    return np.clip(sound, -32768, 32767).astype("<i2")


def denoise(sound: np.ndarray, pauses: list) -> np.ndarray:
    """``(n,)`` float with a Wiener filter for the mean spectrum of the pauses (seconds), if there are any."""
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
