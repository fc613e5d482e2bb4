"""Frame ranges that an edit may change: those around its gesture, up to the strokes of its neighbours."""

from collections.abc import Sequence

import numpy as np

from ..motion import skeleton
from .gestures import Gesture

WANTED, LEAST = 0.8, 0.4
"""Desired and least seconds on either side of a stroke for the transitions to it and from it."""
_MAX_GAP = 0.4
"""Seconds between two spans below which they are merged."""

FrameRange = tuple[int, int]
"""First frame of a range, and the one after its last."""


def range_around(
    others: Sequence[Gesture], first: int, last: int, frames: int, wanted: float = WANTED, least: float = LEAST
) -> FrameRange:
    """Return the span to regenerate around the frames from ``first`` to ``last``, of ``frames`` in all.

    It extends by ``wanted`` seconds, but not into the strokes of ``others``, and in any case by ``least`` seconds."""
    fps = skeleton.FPS
    holds = [one.hold * fps for one in others if one.at * fps < first]
    strokes = [one.stroke * fps for one in others if one.at * fps > last]
    start = max(first - wanted * fps, max(holds, default=-1) + 1)
    stop = min(last + wanted * fps, min(strokes, default=frames) - 1)
    start, stop = min(start, first - least * fps), max(stop, last + least * fps)
    return max(int(np.floor(start)), 0), min(int(np.ceil(stop)) + 1, frames)


def range_until(held: np.ndarray, first: int, last: int, wanted: float) -> FrameRange:
    """Return the span of ``wanted`` seconds around the frames from ``first`` to ``last``, up to the nearest fixed frames.

    Those are marked in ``held`` ``(frames,)``; gestures in the span do not matter."""
    reach, frames = round(wanted * skeleton.FPS), len(held)
    before, after = np.flatnonzero(held[:first]), np.flatnonzero(held[last + 1 :])
    start = max(first - reach, before[-1] + 1 if len(before) else 0)
    return int(start), int(min(last + reach + 1, last + 1 + after[0] if len(after) else frames))


def merge_ranges(spans: Sequence[FrameRange]) -> list[FrameRange]:
    """Return the spans in order of time, with those near each other merged."""
    result: list[FrameRange] = []
    for start, stop in sorted(spans):
        if result and start - result[-1][1] < _MAX_GAP * skeleton.FPS:
            result[-1] = result[-1][0], max(stop, result[-1][1])
        else:
            result.append((start, stop))
    return result


def frame_mask(spans: Sequence[FrameRange], frames: int) -> np.ndarray:
    """Return which of all ``frames`` are in a span, as a mask ``(frames,)``."""
    inside = np.zeros(frames, bool)
    for start, stop in spans:
        inside[start:stop] = True
    return inside
