"""Where the seconds of a take's recording lie on the timeline: evenly behind its start, or as its sound was stretched."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...core.direction.ways import Way
from ...core.motion.face import RATE, Face
from ...core.motion.motion import Motion

WAY = "way"
"""In the provenance of a take: seconds of its recording, and those behind its start at which they are played."""


@dataclass(frozen=True, eq=False)
class Clock:
    """Frames of the scene, ``fps`` a second, for seconds of a recording that begins at frame ``start`` and goes its ``way``."""

    start: float
    fps: float
    way: Way | None = None

    def frame(self, seconds):
        """The frames at which these seconds are played."""
        return self.start + (seconds if self.way is None else self.way.there(seconds)) * self.fps

    def seconds(self, frame):
        """The seconds that are played at these frames, also before the recording and behind it."""
        played = (frame - self.start) / self.fps
        return played if self.way is None else self.way.back(played)


def clock(told: Mapping, fps: float) -> Clock:
    """The clock of a take by its provenance."""
    return Clock(told["start"], fps, way(told))


def way(told: Mapping) -> Way | None:
    """The way that a take's recording goes, None where it is played as it is, or nothing that makes sense is told."""
    pairs = told.get(WAY)
    try:
        old, new = np.array(pairs if isinstance(pairs, list) else [], float)
    except (TypeError, ValueError):
        return None
    sound = old.ndim == 1 and len(old) > 1 and np.isfinite([old, new]).all() and (np.diff([old, new]) > 0).all()
    return Way(new, old) if sound else None


def stated(way: Way | None) -> list | None:
    """A way as provenance has it."""
    return None if way is None else [way.old.round(4).tolist(), way.new.round(4).tolist()]


def played(motion: Motion, way: Way | None) -> Motion:
    """A motion with its words and its face as it is when its recording goes that way."""
    if way is None:
        return motion
    count = max(round(float(way.there(motion.duration)) * motion.fps), 1)
    made = motion.at(way.back(np.arange(count) / motion.fps) * motion.fps, motion.fps)
    words = tuple((word, *way.there([start, end]).tolist()) for word, start, end in motion.words)
    return replace(made, words=words, face=motion.face and _face(motion.face, way))


def _face(face: Face, way: Way) -> Face:
    count = max(round(float(way.there(face.duration)) * RATE), 1)
    weights = face.at(way.back(np.arange(count) / RATE), RATE)
    sounds = tuple((phone, *way.there([start, end]).tolist()) for phone, start, end in face.sounds)
    return replace(face, weights=weights, closures=way.there(face.closures), sounds=sounds)
