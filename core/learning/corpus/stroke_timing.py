"""Warps captured talk in time so that peaks of its speed fall on accents of the speech, by dynamic programming."""

import numpy as np

from ...motion import skeleton

SLOWEST, FASTEST = 0.7, 1.75
"""Playback rates between two matched accents: outside, movements look slowed down or hurried."""
_UNEVEN = 1.6
"""Cost of a rate that is twice or half the wanted one for a second, in accents of strength 1 that go unmatched."""
_WINDOW = 0.35
"""How far, in each second since the stretch's begin, a peak may be from where the wanted rate puts it."""
_MARGIN = 2
"""Frames by which it may be farther: without them a match soon after the begin would need luck."""
_FIRST, _LEAST = 3, 2
"""Frames from the begin within which no accent is met, and between two matches at least: the rate there would be a jerk."""


def warp(
    peaks: np.ndarray, first: float, frames: int, accents: np.ndarray, strengths: np.ndarray, rate: float, obedience: float
) -> np.ndarray:
    """Return the fractional source frames ``(frames,)`` to be shown, from ``first`` on, increasing.

    ``peaks`` ``(k,)`` are frames of the source; ``accents`` ``(n,)`` and their ``strengths`` 0..1 are in frames of the result;
    ``rate`` is the wanted playback rate and ``obedience`` what a matched accent of strength 1 is worth.
    """
    times, places = _matches(peaks - first, accents, obedience * strengths, rate)
    left = max(frames - 1 - times[-1], 1)
    ends = np.append(times, times[-1] + left), np.append(places, places[-1] + rate * left)
    return first + _smooth_path(np.arange(frames), *ends)


def _matches(peaks: np.ndarray, accents: np.ndarray, worth: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the times and the places of the best chain of matched accents, which begins with (0, 0)."""
    pairs = [(0.0, 0.0, 0.0)]
    for accent, value in zip(accents, worth, strict=True):
        if accent > _FIRST:
            near = peaks[np.abs(peaks - rate * accent) < _WINDOW * rate * accent + _MARGIN]
            pairs += [(accent, float(peak), value) for peak in near]
    time, place, value = np.array(pairs).T
    best, before = value.copy(), np.full(len(pairs), -1)
    for k in range(1, len(pairs)):
        span = time[k] - time[:k]
        own = np.divide(place[k] - place[:k], span, out=np.zeros(k), where=span > _LEAST)
        cost = _UNEVEN * np.log2(np.maximum(own, 1e-3) / rate) ** 2 * span / skeleton.FPS
        gain = np.where((own >= SLOWEST) & (own <= FASTEST), best[:k] - cost, -np.inf)
        j = int(np.argmax(gain))
        best[k], before[k] = value[k] + gain[j], j
    chain, k = [], int(np.argmax(best))
    while k >= 0:
        chain.append(k)
        k = before[k]
    chain.reverse()
    return time[chain], place[chain]


def _smooth_path(at: np.ndarray, times: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return places at frames ``at`` through the matches, with rates that change gradually."""
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(times, places, extrapolate=True)(at)
