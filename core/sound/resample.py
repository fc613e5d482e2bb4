"""Resamples a sound that arrives in pieces: windowed sinc interpolation with one filter per phase.

Length, cut-off and window are those of FFmpeg's resampler (32 zero crossings, 0.97, Kaiser 9), so the result does not depend
on which of the two decoded a file."""

from collections.abc import Iterable, Iterator

import numpy as np

_CROSSINGS = 16
_CUTOFF = 0.97
_BETA = 9.0
_MIN_SAMPLES = 1 << 18
"""Samples collected before filtering, because every piece costs one product per phase."""
_PHASES = 512
"""Filters computed at once: there can be 16,000 of them, and for high rates they are long."""


def resample(pieces: Iterable[np.ndarray], source: int, target: int) -> Iterator[np.ndarray]:
    """Resample float32 pieces ``(n,)`` at ``source`` Hz to pieces at ``target`` Hz; the duration stays, up to a sample."""
    if source == target:
        yield from pieces
        return
    stream, waiting, count = _Stream(source, target), [], 0
    for piece in pieces:
        waiting.append(piece)
        count += len(piece)
        if count >= _MIN_SAMPLES:
            yield stream.feed(np.concatenate(waiting))
            waiting, count = [], 0
    if waiting:
        yield stream.feed(np.concatenate(waiting))
    yield stream.finish()


class _Stream:
    """Resampler state between pieces: the last input samples, and how many samples came in and went out."""

    def __init__(self, source: int, target: int):
        common = int(np.gcd(source, target))
        self._up, self._down = target // common, source // common
        self._kernels = _kernels(self._up, self._down)
        self._half = self._kernels.shape[1] // 2
        self._held = np.zeros(self._half, np.float32)
        self._begin, self._samples_in, self._samples_out = -self._half, 0, 0

    def feed(self, piece: np.ndarray) -> np.ndarray:
        """Take input samples ``(n,)``; return the output samples that are complete."""
        self._samples_in += len(piece)
        return self._resample(piece, -(-(self._samples_in - self._half) * self._up // self._down))

    def finish(self) -> np.ndarray:
        """Return the remaining output samples."""
        return self._resample(np.zeros(self._half + 1, np.float32), -(-self._samples_in * self._up // self._down))

    def _resample(self, piece: np.ndarray, end: int) -> np.ndarray:
        """Add ``piece`` to the input and return the output samples before number ``end``."""
        self._held = np.concatenate([self._held, piece.astype(np.float32, copy=False)])
        result = np.empty(max(end - self._samples_out, 0), np.float32)
        if not len(result):
            return result
        windows = np.lib.stride_tricks.sliding_window_view(self._held, 2 * self._half)
        for number in range(min(self._up, len(result))):
            base, phase = divmod((self._samples_out + number) * self._down, self._up)
            count = len(range(number, len(result), self._up))
            rows = windows[base - self._half + 1 - self._begin :: self._down][:count]
            result[number :: self._up] = np.einsum("ij,j->i", rows, self._kernels[phase])
        self._samples_out = end
        needed = max(end * self._down // self._up - self._half + 1 - self._begin, 0)
        self._held, self._begin = self._held[needed:].copy(), self._begin + needed
        return result


def _kernels(up: int, down: int) -> np.ndarray:
    """Return filters ``(up, 2 * half)`` float32: weights of the samples around a time ``phase / up`` samples after a sample."""
    scale = min(1.0, _CUTOFF * up / down)
    half = int(np.ceil(_CROSSINGS / scale))
    steps, kernels = np.arange(-half + 1, half + 1), np.empty((up, 2 * half), np.float32)
    for first in range(0, up, _PHASES):
        away = steps - np.arange(first, min(first + _PHASES, up))[:, None] / up
        window = np.i0(_BETA * np.sqrt(np.maximum(1 - (away / half) ** 2, 0)))
        weights = np.sinc(scale * away) * window
        kernels[first : first + _PHASES] = weights / weights.sum(axis=1, keepdims=True)
    return kernels
