"""Finds peaks of a track by prominence and distance, with widths, like ``scipy.signal.find_peaks`` and ``peak_widths``."""

from typing import NamedTuple

import numpy as np


class Peaks(NamedTuple):
    """Sample numbers ``places`` ``(p,)`` in ascending order, ``prominences`` ``(p,)``, and ``widths`` ``(p,)`` in samples."""

    places: np.ndarray
    prominences: np.ndarray
    widths: np.ndarray


def find_peaks(track: np.ndarray, prominence: float, distance: int, depth: float) -> Peaks:
    """Find the peaks of ``(n,)`` with at least this ``prominence`` that are at least ``distance`` samples apart.

    Of two peaks too close together the higher one stays. Widths are measured below the peak by ``depth`` times its
    prominence. The peak of a plateau is its middle."""
    track = np.asarray(track, float)
    places = _maxima(track)
    outstanding = _prominences(track, places)
    kept = _far_apart(track, places, distance)
    kept &= outstanding >= prominence
    places, outstanding = places[kept], outstanding[kept]
    height = track[places] - depth * outstanding
    return Peaks(places, outstanding, _crossing(track, places, height, 1) - _crossing(track, places, height, -1))


def _maxima(track: np.ndarray) -> np.ndarray:
    """Return the sample numbers of local maxima; of a plateau, its middle."""
    steps = np.flatnonzero(np.diff(track)) + 1
    begins, ends = np.append(0, steps), np.append(steps, len(track))
    values = track[begins] if len(track) else track
    top = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])) + 1
    return (begins[top] + ends[top] - 1) // 2


def _prominences(track: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the prominence of every maximum: its height above the higher of the two lowest points that separate it from
    higher maxima on its left and right."""
    if not len(places):
        return np.zeros(0)
    heights = track[places].tolist()
    valleys = np.minimum.reduceat(track, np.append(0, places)).tolist()
    left = _lowest_valleys(heights, valleys[:-1])
    right = _lowest_valleys(heights[::-1], valleys[:0:-1])[::-1]
    return np.array(heights) - np.maximum(left, right)


def _lowest_valleys(heights: list[float], valleys: list[float]) -> list[float]:
    """Return for every maximum the lowest valley since the last higher one; ``valleys[k]`` lies before maximum ``k``."""
    lowest: list[float] = []
    higher: list[int] = []
    for number, (height, low) in enumerate(zip(heights, valleys, strict=True)):
        while higher and heights[higher[-1]] <= height:
            low = min(low, lowest[higher.pop()])
        lowest.append(low)
        higher.append(number)
    return lowest


def _far_apart(track: np.ndarray, places: np.ndarray, distance: int) -> np.ndarray:
    """Return a mask of the maxima that remain when each, highest first, removes those nearer than ``distance``."""
    kept = np.ones(len(places), bool)
    first = np.searchsorted(places, places - distance, side="right")
    last = np.searchsorted(places, places + distance, side="left")
    for number in np.argsort(track[places])[::-1]:
        if kept[number]:
            kept[first[number] : last[number]] = False
            kept[number] = True
    return kept


def _crossing(track: np.ndarray, places: np.ndarray, height: np.ndarray, step: int) -> np.ndarray:
    """Return where the track falls to ``height`` on one side of each peak (``step`` -1 or 1), interpolated linearly."""
    at = places.copy()
    above = np.arange(len(at))
    while len(above):
        at[above] += step
        above = above[track[at[above]] > height[above]]
    inner = at - step
    return inner + step * (track[inner] - height) / (track[inner] - track[at])
