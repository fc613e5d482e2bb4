"""Interpolation between frames, smooth steps and ramps, and simplification of curves."""

import numpy as np


def sample_cubic(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Sample ``values`` ``(frames, ...)`` at fractional frames ``at`` ``(n,)`` on a Catmull-Rom curve; ends are held."""
    last = len(values) - 1
    at = np.clip(np.asarray(at, float), 0, last)
    index = np.minimum(at.astype(int), max(last - 1, 0))
    t = (at - index).astype(np.float32).reshape(-1, *[1] * (values.ndim - 1))
    p0, p1, p2, p3 = (values[np.clip(index + step, 0, last)] for step in (-1, 0, 1, 2))
    return p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)))


def ramp(time: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Return a minimum-jerk rise from 0 at ``begin`` to 1 at ``end``."""
    x = np.clip((time - begin) / max(end - begin, 1e-6), 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x)


def smoothstep(x: np.ndarray, low: float = 0.0, high: float = 1.0) -> np.ndarray:
    """Return 0 below ``low``, 1 above ``high`` and a smooth step between (same shape as ``x``)."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def bounded(excess: np.ndarray, width: float) -> np.ndarray:
    """What must be taken away so that of an ``excess`` above 0 less than ``width`` remains, setting in softly."""
    over = np.maximum(excess, 0)
    return over**2 / (over + width)


def simplify_polyline(values: np.ndarray, straight: float) -> np.ndarray:
    """Return the indices of a polyline that approximates ``values`` within ``straight`` (Ramer-Douglas-Peucker).

    The first and the last index are included."""
    indices, pending = {0, len(values) - 1}, [(0, len(values) - 1)]
    while pending:
        low, high = pending.pop()
        inner = np.arange(low + 1, high)
        if not len(inner):
            continue
        line = values[low] + (values[high] - values[low]) * (inner - low) / (high - low)
        error = np.abs(values[inner] - line)
        if error.max() > straight:
            middle = int(inner[error.argmax()])
            indices.add(middle)
            pending += [(low, middle), (middle, high)]
    return np.array(sorted(indices))


def true_runs(mask: np.ndarray) -> np.ndarray:
    """Return first and end frame ``(n, 2)`` of every run in which ``mask`` ``(frames,)`` is true; the end is exclusive."""
    return np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]]).astype(int))).reshape(-1, 2)
