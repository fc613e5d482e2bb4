"""Peaks that stand out of a track, and how wide they are (as ``scipy.signal.find_peaks`` and ``peak_widths`` tell)."""

from typing import NamedTuple

import numpy as np


class Peaks(NamedTuple):
    """``places`` ``(p,)`` of samples in order of time, ``(p,)`` ``prominences``, and ``widths`` in samples."""

    places: np.ndarray
    prominences: np.ndarray
    widths: np.ndarray


def find(track: np.ndarray, prominence: float, distance: int, depth: float) -> Peaks:
    """Peaks of ``(n,)`` that stand out by ``prominence``, at least ``distance`` samples apart, the higher of two first.

    Their widths are taken ``depth`` of their own prominence below them. The middle of a plateau is its peak.
    """
    track = np.asarray(track, float)
    places = _maxima(track)
    outstanding = _prominences(track, places)
    kept = _apart(track, places, distance)
    kept &= outstanding >= prominence
    places, outstanding = places[kept], outstanding[kept]
    height = track[places] - depth * outstanding
    return Peaks(places, outstanding, _crossing(track, places, height, 1) - _crossing(track, places, height, -1))


def _maxima(track: np.ndarray) -> np.ndarray:
    """Middles of stretches of one value that are higher than both neighbours."""
    steps = np.flatnonzero(np.diff(track)) + 1
    begins, ends = np.append(0, steps), np.append(steps, len(track))
    values = track[begins] if len(track) else track
    top = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])) + 1
    return (begins[top] + ends[top] - 1) // 2


def _prominences(track: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Height of every maximum over the higher of the lowest places between it and what is higher on either side."""
    if not len(places):
        return np.zeros(0)
    heights = track[places].tolist()
    valleys = np.minimum.reduceat(track, np.append(0, places)).tolist()
    left = _lowest(heights, valleys[:-1])
    right = _lowest(heights[::-1], valleys[:0:-1])[::-1]
    return np.array(heights) - np.maximum(left, right)


def _lowest(heights: list[float], valleys: list[float]) -> list[float]:
    """For every maximum the lowest valley since a higher one; ``valleys[k]`` lies before maximum ``k``."""
    found: list[float] = []
    higher: list[int] = []
    for number, (height, low) in enumerate(zip(heights, valleys, strict=True)):
        while higher and heights[higher[-1]] <= height:
            low = min(low, found[higher.pop()])
        found.append(low)
        higher.append(number)
    return found


def _apart(track: np.ndarray, places: np.ndarray, distance: int) -> np.ndarray:
    """Which maxima stay when the highest push out all that are nearer than ``distance``."""
    kept = np.ones(len(places), bool)
    first = np.searchsorted(places, places - distance, side="right")
    last = np.searchsorted(places, places + distance, side="left")
    for number in np.argsort(track[places])[::-1]:
        if kept[number]:
            kept[first[number] : last[number]] = False
            kept[number] = True
    return kept


def _crossing(track: np.ndarray, places: np.ndarray, height: np.ndarray, step: int) -> np.ndarray:
    """Where the track falls to ``height`` on one side of its peaks, between two samples."""
    at = places.copy()
    above = np.arange(len(at))
    while len(above):
        at[above] += step
        above = above[track[at[above]] > height[above]]
    inner = at - step
    return inner + step * (track[inner] - height) / (track[inner] - track[at])
