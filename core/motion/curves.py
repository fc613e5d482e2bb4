"""Values between frames, and the curve that all deliberate movement is made of."""

import numpy as np


def between(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """``values`` ``(frames, ...)`` at fractional frames ``at`` ``(n,)`` by a Catmull-Rom curve; beyond the ends those there."""
    last = len(values) - 1
    at = np.clip(np.asarray(at, float), 0, last)
    index = np.minimum(at.astype(int), max(last - 1, 0))
    t = (at - index).astype(np.float32).reshape(-1, *[1] * (values.ndim - 1))
    before, here, there, after = (values[np.clip(index + step, 0, last)] for step in (-1, 0, 1, 2))
    return here + 0.5 * t * (
        there - before + t * (2 * before - 5 * here + 4 * there - after + t * (3 * (here - there) + after - before))
    )


def ramp(time: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Minimum-jerk rise from 0 at ``begin`` to 1 at ``end``."""
    x = np.clip((time - begin) / max(end - begin, 1e-6), 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x)


def bends(values: np.ndarray, straight: float) -> np.ndarray:
    """Numbers of the values between which all others lie on lines, within ``straight``, the first and the last among them."""
    kept, todo = {0, len(values) - 1}, [(0, len(values) - 1)]
    while todo:
        low, high = todo.pop()
        inner = np.arange(low + 1, high)
        if not len(inner):
            continue
        line = values[low] + (values[high] - values[low]) * (inner - low) / (high - low)
        off = np.abs(values[inner] - line)
        if off.max() > straight:
            middle = int(inner[off.argmax()])
            kept.add(middle)
            todo += [(low, middle), (middle, high)]
    return np.array(sorted(kept))


def runs(mask: np.ndarray) -> np.ndarray:
    """First frame and the one after the last ``(n, 2)`` of every stretch in which ``mask`` ``(frames,)`` holds."""
    return np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]]).astype(int))).reshape(-1, 2)
