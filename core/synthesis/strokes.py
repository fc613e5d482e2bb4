"""Finds the strokes of a motion, peaks of the faster wrist's speed, and the phases of each."""

import numpy as np

from ..motion import skeleton
from ..sound import peaks

SPEED, PROMINENCE, APART = 0.25, 0.15, 0.4
"""A stroke is a peak of the faster wrist's speed: its least height and prominence in m/s, and least distance to others in s."""
_STROKE_SHARE = 0.3
"""Share of the peak speed above which a frame belongs to the stroke."""
_MOVING_SPEED = 0.12
"""Wrist speed in m/s above which a frame belongs to preparation or release."""
MAX_PREPARATION, MAX_RELEASE = 0.8, 0.9
"""Longest preparation and release in seconds."""


def wrist_speeds(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the speeds of the wrists ``(frames, 2)`` in metres per second, of directions ``(frames, 9, 3)``."""
    if len(directions) < 2:
        return np.zeros((len(directions), 2))
    return skeleton.length(np.gradient(skeleton.wrists(directions), axis=0)) * fps


def stroke_times(directions: np.ndarray, fps: float = skeleton.FPS) -> list[float]:
    """Return the seconds of the strokes of directions ``(frames, 9, 3)``, as :func:`find_gestures` finds them."""
    faster = wrist_speeds(directions, fps).max(1)
    return [(place + peak_offset(faster.tolist(), place)) / fps for place in stroke_places(faster, fps)]


def stroke_places(faster: np.ndarray, fps: float) -> list[int]:
    """Return the frames of strokes: peaks of the faster wrist's speed ``(frames,)``."""
    places = [] if len(faster) < 3 else peaks.find_peaks(faster, PROMINENCE, round(APART * fps), 0.5).places
    return [int(place) for place in places if faster[place] > SPEED]


def stroke_span(faster: list[float], place: int) -> tuple[int, int]:
    """Return the first and last frame of the stroke around a peak."""
    least, start, hold = _STROKE_SHARE * faster[place], place, place
    while start > 0 and faster[start] > least and faster[start - 1] < faster[start]:
        start -= 1
    while hold < len(faster) - 1 and faster[hold] > least and faster[hold + 1] < faster[hold]:
        hold += 1
    return start, hold


def preparation_start(faster: list[float], start: int, first: int) -> int:
    """Return the frame at which the preparation of a stroke starts, not before ``first``."""
    while start > first and faster[start - 1] > _MOVING_SPEED:
        start -= 1
    return start


def release_span(faster: list[float], hold: int, last: int, longest: int) -> tuple[int, int]:
    """Return the frames at which the release after a hold starts and ends: by ``last``, and in at most ``longest`` frames."""
    release = hold
    while release < last and (faster[release] <= _MOVING_SPEED or faster[release + 1] < faster[release]):
        release += 1
    end = release
    while end < min(last, release + longest) and faster[end] > _MOVING_SPEED:
        end += 1
    return release, end


def peak_offset(values: list[float], place: int) -> float:
    """Return the offset in frames of a peak between samples, by a parabola through it and its neighbours."""
    before, here, after = values[place - 1 : place + 2]
    bend = before - 2 * here + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0
