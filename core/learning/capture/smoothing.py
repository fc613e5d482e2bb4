"""Cleans tracks of points over time: outliers, confidence, and smoothing that keeps strokes. Needs numpy alone."""

import numpy as np

_OUTLIER = 4.0
"""Distance to the median of the neighbours, in deviations of the track from that median, beyond which a point is an outlier."""
_NEIGHBOURS = 2
WIDTH = 0.07
"""Seconds of the smoothing's Gaussian: a stroke is never shorter than a quarter of a second."""
_REACH = 3.0
_LEAST = 1.5
"""Least weight, in pictures that are surely seen, of those around a moment by which it counts as seen."""


def outliers(track: np.ndarray, scale: float) -> np.ndarray:
    """Return which rows of ``(n, d)`` leap out of their neighbours' median, by at least ``scale``; NaN rows never do."""
    if len(track) < 2 * _NEIGHBOURS + 1:
        return np.zeros(len(track), bool)
    padded = np.pad(track, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), mode="edge")
    around = np.stack([padded[shift : shift + len(track)] for shift in range(2 * _NEIGHBOURS + 1)])
    seen = np.isfinite(around).all(-1).sum(0) > _NEIGHBOURS
    middle = np.full(track.shape, np.nan)
    middle[seen] = np.nanmedian(around[:, seen], axis=0)
    away = np.linalg.norm(track - middle, axis=-1)
    known = away[np.isfinite(away)]
    usual = 1.4826 * np.median(known) if len(known) else 0.0
    return np.nan_to_num(away) > max(_OUTLIER * usual, scale)


def resample(
    times: np.ndarray, track: np.ndarray, weights: np.ndarray, scenes: np.ndarray, at: np.ndarray, width: float = WIDTH
) -> tuple[np.ndarray, np.ndarray]:
    """Return a track ``(n, d)`` with ``weights`` ``(n,)`` at other times ``(m, d)``, and which of these are seen ``(m,)``.

    A parabola is fitted around every moment, so that peaks stay; pictures of other ``scenes`` ``(n,)`` do not count.
    """
    weights = np.where(np.isfinite(track).all(-1), weights, 0.0)
    values = np.nan_to_num(track)
    result, seen = np.zeros((len(at), track.shape[1])), np.zeros(len(at), bool)
    if not len(times):
        return result, seen
    low, high = np.searchsorted(times, at - _REACH * width), np.searchsorted(times, at + _REACH * width)
    nearest = np.clip(np.searchsorted(times, at), 0, len(times) - 1)
    for row, (first, last) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        if last <= first:
            continue
        here = slice(first, last)
        apart = (times[here] - at[row]) / width
        weight = weights[here] * np.exp(-0.5 * apart**2) * (scenes[here] == scenes[nearest[row]])
        total = weight.sum()
        near = (weights[here] * (scenes[here] == scenes[nearest[row]])).sum()
        if total < 0.2 or near < min(_LEAST, last - first):
            continue
        result[row], seen[row] = _parabola(apart, values[here], weight), True
    return result, seen


def _parabola(apart: np.ndarray, values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the value at 0 of a parabola through weighted values, a little stiffened where there are few."""
    powers = np.stack([np.ones_like(apart), apart, apart**2], 1)
    left = powers.T @ (powers * weight[:, None]) + np.diag([0.0, 0.05, 0.3])
    return np.linalg.solve(left, powers.T @ (values * weight[:, None]))[0]


def fill(track: np.ndarray, seen: np.ndarray, rest: np.ndarray, longest: int, ease: int) -> np.ndarray:
    """Return a track ``(n, d)`` in which what is not ``seen`` is bridged: gaps up to ``longest`` frames in a straight line,
    longer ones by way of ``rest`` ``(d,)``, reached within ``ease`` frames.
    """
    known = np.flatnonzero(seen)
    if not len(known):
        return np.broadcast_to(rest, track.shape).copy()
    result, rows = track.copy(), np.arange(len(track))
    for column in range(track.shape[1]):
        result[:, column] = np.interp(rows, known, track[known, column])
    before = rows - np.maximum.accumulate(np.where(seen, rows, -len(rows)))
    after = np.minimum.accumulate(np.where(seen, rows, 3 * len(rows))[::-1])[::-1] - rows
    share = np.clip(np.minimum(before, after) / ease, 0, 1) * (before + after > longest + 1)
    share = (share**2 * (3 - 2 * share))[:, None]
    return result * (1 - share) + rest * share
