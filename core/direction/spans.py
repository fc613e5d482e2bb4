"""Which frames an edit may touch: those around its gesture, as far as the neighbours' strokes let it."""

from collections.abc import Sequence

import numpy as np

from ..motion import skeleton
from .gestures import Gesture

WANTED, LEAST = 0.8, 0.4
"""Seconds on either side of a stroke in which hands come to it and go from it: as wished, and at least."""
_JOINED = 0.4
"""Seconds between two spans up to which they are one."""

Span = tuple[int, int]
"""First frame, and the one after the last."""


def around(found: Sequence[Gesture], first: int, last: int, frames: int, wanted: float = WANTED, least: float = LEAST) -> Span:
    """The span to make anew around frames ``first`` to ``last``; ``found`` are the gestures that are to stay, and whose strokes
    it does not touch but where less than ``least`` seconds would be left on that side.
    """
    fps = skeleton.FPS
    holds = [one.hold * fps for one in found if one.at * fps < first]
    strokes = [one.stroke * fps for one in found if one.at * fps > last]
    start = max(first - wanted * fps, max(holds, default=-1) + 1)
    stop = min(last + wanted * fps, min(strokes, default=frames) - 1)
    start, stop = min(start, first - least * fps), max(stop, last + least * fps)
    return max(int(np.floor(start)), 0), min(int(np.ceil(stop)) + 1, frames)


def until(held: np.ndarray, first: int, last: int, wanted: float) -> Span:
    """The span that lies ``wanted`` seconds around frames ``first`` to ``last``, but no farther than to the next one that is
    ``held`` ``(frames,)``, whatever gestures are in it.
    """
    reach, frames = round(wanted * skeleton.FPS), len(held)
    before, after = np.flatnonzero(held[:first]), np.flatnonzero(held[last + 1 :])
    start = max(first - reach, before[-1] + 1 if len(before) else 0)
    return int(start), int(min(last + reach + 1, last + 1 + after[0] if len(after) else frames))


def joined(spans: Sequence[Span]) -> list[Span]:
    """Spans in order of time, those that lie near each other as one."""
    result: list[Span] = []
    for start, stop in sorted(spans):
        if result and start - result[-1][1] < _JOINED * skeleton.FPS:
            result[-1] = result[-1][0], max(stop, result[-1][1])
        else:
            result.append((start, stop))
    return result


def mask(spans: Sequence[Span], frames: int) -> np.ndarray:
    """Which of all ``frames`` the spans hold, ``(frames,)``."""
    inside = np.zeros(frames, bool)
    for start, stop in spans:
        inside[start:stop] = True
    return inside
