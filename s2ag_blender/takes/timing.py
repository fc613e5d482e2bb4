"""Converts between seconds of a take's recording and scene frames, also where its sound strip is stretched."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.editing.time_alignment import TimeMap
from ...core.motion.face import RATE, Face
from ...core.motion.motion import Motion

WAY = "way"
"""Key in the provenance of a take: seconds of its recording, and the seconds after its start at which they are played."""


@dataclass(frozen=True, eq=False)
class Clock:
    """Converts seconds of a recording, which starts at frame ``start`` and follows the time warp ``way``, to scene frames."""

    start: float
    fps: float
    way: TimeMap | None = None

    def frame(self, seconds: Any) -> Any:
        """Return the frames at which these seconds are played; numbers or arrays."""
        return self.start + (seconds if self.way is None else self.way.there(seconds)) * self.fps

    def seconds(self, frame: Any) -> Any:
        """Return the seconds that are played at these frames, also before and after the recording; numbers or arrays."""
        played = (frame - self.start) / self.fps
        return played if self.way is None else self.way.back(played)


def clock_of(meta: Mapping[str, Any], fps: float) -> Clock:
    """Return the clock of a take from its provenance."""
    return Clock(meta["start"], fps, stored_time_map(meta))


def stored_time_map(meta: Mapping[str, Any]) -> TimeMap | None:
    """Return the time warp of a take's recording from its provenance; None for none, or if invalid."""
    pairs = meta.get(WAY)
    try:
        old, new = np.array(pairs if isinstance(pairs, list) else [], float)
    except (TypeError, ValueError):
        return None
    valid = old.ndim == 1 and len(old) > 1 and np.isfinite([old, new]).all() and (np.diff([old, new]) > 0).all()
    return TimeMap(new, old) if valid else None


def time_map_as_meta(way: TimeMap | None) -> list[list[float]] | None:
    """Return a time warp as stored in provenance."""
    return None if way is None else [way.old.round(4).tolist(), way.new.round(4).tolist()]


def retimed_motion(motion: Motion, way: TimeMap | None) -> Motion:
    """Return a motion with its words and face, warped in time like its recording."""
    if way is None:
        return motion
    count = max(round(float(way.there(motion.duration)) * motion.fps), 1)
    warped = motion.at(way.back(np.arange(count) / motion.fps) * motion.fps, motion.fps)
    words = tuple((word, *way.there([start, end]).tolist()) for word, start, end in motion.words)
    return replace(warped, words=words, face=motion.face and _face(motion.face, way))


def _face(face: Face, way: TimeMap) -> Face:
    count = max(round(float(way.there(face.duration)) * RATE), 1)
    weights = face.at(way.back(np.arange(count) / RATE), RATE)
    sounds = tuple((phone, *way.there([start, end]).tolist()) for phone, start, end in face.sounds)
    return replace(face, weights=weights, closures=way.there(face.closures), sounds=sounds)
