"""Another sampling rate for a sound that comes in pieces: windowed sinc, one filter for every phase of the result.

Length, cut-off and window are those of FFmpeg's resampler (32 zero crossings, 0.97, Kaiser 9), so that a sound is the same
whoever decoded it.
"""

from collections.abc import Iterable, Iterator

import numpy as np

_CROSSINGS = 16
_CUTOFF = 0.97
_BETA = 9.0
_PIECE = 1 << 18
"""Samples that are waited for: short pieces would cost a product for every phase each."""
_PHASES = 512
"""Filters that are computed at once: an odd rate has 16,000 of them, a high one long ones."""


def resampled(pieces: Iterable[np.ndarray], source: int, target: int) -> Iterator[np.ndarray]:
    """Float32 pieces ``(m,)`` at ``target`` Hz of pieces ``(n,)`` at ``source`` Hz, as long in seconds up to a sample."""
    if source == target:
        yield from pieces
        return
    stream, waiting, count = _Stream(source, target), [], 0
    for piece in pieces:
        waiting.append(piece)
        count += len(piece)
        if count >= _PIECE:
            yield stream.feed(np.concatenate(waiting))
            waiting, count = [], 0
    if waiting:
        yield stream.feed(np.concatenate(waiting))
    yield stream.finish()


class _Stream:
    """What one piece leaves for the next: the last samples, how many came, and how many went."""

    def __init__(self, source: int, target: int):
        common = int(np.gcd(source, target))
        self._up, self._down = target // common, source // common
        self._kernels = _kernels(self._up, self._down)
        self._half = self._kernels.shape[1] // 2
        self._held = np.zeros(self._half, np.float32)
        self._begin, self._came, self._went = -self._half, 0, 0

    def feed(self, piece: np.ndarray) -> np.ndarray:
        self._came += len(piece)
        return self._made(piece, -(-(self._came - self._half) * self._up // self._down))

    def finish(self) -> np.ndarray:
        return self._made(np.zeros(self._half + 1, np.float32), -(-self._came * self._up // self._down))

    def _made(self, piece: np.ndarray, end: int) -> np.ndarray:
        """Samples up to ``end`` of the result, after ``piece`` has come."""
        self._held = np.concatenate([self._held, piece.astype(np.float32, copy=False)])
        result = np.empty(max(end - self._went, 0), np.float32)
        if not len(result):
            return result
        windows = np.lib.stride_tricks.sliding_window_view(self._held, 2 * self._half)
        for number in range(min(self._up, len(result))):
            base, phase = divmod((self._went + number) * self._down, self._up)
            count = len(range(number, len(result), self._up))
            rows = windows[base - self._half + 1 - self._begin :: self._down][:count]
            result[number :: self._up] = np.einsum("ij,j->i", rows, self._kernels[phase])
        self._went = end
        needed = max(end * self._down // self._up - self._half + 1 - self._begin, 0)
        self._held, self._begin = self._held[needed:].copy(), self._begin + needed
        return result


def _kernels(up: int, down: int) -> np.ndarray:
    """``(up, 2 * half)`` float32: weights of the samples around a moment that lies ``phase / up`` behind a sample."""
    scale = min(1.0, _CUTOFF * up / down)
    half = int(np.ceil(_CROSSINGS / scale))
    steps, kernels = np.arange(-half + 1, half + 1), np.empty((up, 2 * half), np.float32)
    for first in range(0, up, _PHASES):
        away = steps - np.arange(first, min(first + _PHASES, up))[:, None] / up
        window = np.i0(_BETA * np.sqrt(np.maximum(1 - (away / half) ** 2, 0)))
        found = np.sinc(scale * away) * window
        kernels[first : first + _PHASES] = found / found.sum(axis=1, keepdims=True)
    return kernels
