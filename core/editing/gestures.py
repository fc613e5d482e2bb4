"""Detects the gestures of a take: the phases of each (preparation, stroke, hold, release), its hand, size and word."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..motion.motion import Motion
from ..synthesis import strokes
from ..synthesis.strokes import wrist_speeds
from .names import BEAT, REST  # noqa: F401

HANDS = ("left", "right", "both")

_BOTH_SHARE = 0.55
"""Share of the faster wrist's speed from which the slower hand takes part in the gesture."""
_MATCH_SECONDS = 0.35
"""Largest distance in time between a stroke and the word or semantic gesture that belongs to it."""


@dataclass(frozen=True)
class Gesture:
    """A gesture of a take. Its times are in seconds and in order.

    The preparation starts at ``begin``, the stroke at ``stroke`` with its peak of speed ``at``, the hold at ``hold``, the
    release at ``release``; it is over at ``end``. ``hand`` is one of :data:`HANDS`, ``kind`` a semantic gesture
    (:mod:`vocabulary`) or :data:`BEAT`, ``size`` the path of the leading wrist in the stroke in metres, ``word`` the word
    that is spoken meanwhile, or ""."""

    begin: float
    stroke: float
    at: float
    hold: float
    release: float
    end: float
    hand: str
    kind: str
    size: float
    word: str


def find_gestures(motion: Motion, around: float | None = None, within: float = 0.25) -> list[Gesture]:
    """Return the gestures of a motion in order of time.

    If ``around`` is given, only those whose strokes are at most ``within`` seconds (and one frame) away from it."""
    names = _TimedNames(meant_gestures(motion))
    words = _TimedNames([(word, 0.5 * (start + end)) for word, start, end in motion.words])
    speed, fps = wrist_speeds(motion.directions, motion.fps), motion.fps
    faster = speed.max(1)
    places = strokes.stroke_places(faster, fps)
    faster = faster.tolist()
    rows = list(range(len(places)))
    if around is not None:
        rows = [row for row in rows if abs(places[row] / fps - around) <= within + 1 / fps]
        first, last = (max(rows[0] - 1, 0), rows[-1] + 2) if rows else (0, 0)
        places, rows = places[first:last], [row - first for row in rows]
    spans = [strokes.stroke_span(faster, place) for place in places]
    detected = []
    for row in rows:
        place, (start, hold) = places[row], spans[row]
        before = spans[row - 1][1] if row else 0
        after = spans[row + 1][0] if row + 1 < len(spans) else len(faster) - 1
        begin = strokes.preparation_start(faster, start, max(before, start - round(strokes.MAX_PREPARATION * fps)))
        release, end = strokes.release_span(faster, hold, max(after, hold), round(strokes.MAX_RELEASE * fps))
        at = (place + strokes.peak_offset(faster, place)) / fps
        hand = leading_hand(speed[start : hold + 1])
        size = float(speed[start : hold + 1].sum(0).max() / fps)
        kind, word = names.near(at) or BEAT, words.near(at)
        phases = begin / fps, start / fps, at, hold / fps, release / fps, end / fps
        detected.append(Gesture(*phases, hand, kind, size, word))
    return detected


def normalize_word(word: str) -> str:
    """Return a word of a transcript in lower case and without punctuation, as edits name it."""
    return word.lower().strip(".,;:!?\"'()…-–—")


def meant_gestures(motion: Motion) -> list[tuple[str, float]]:
    """Return the semantic gestures in a motion's provenance: names, and the times of their strokes in seconds."""
    entries = motion.meta.get("shows")
    entries = entries if isinstance(entries, list) else []
    return [(str(pair[0]), float(pair[1])) for pair in entries if isinstance(pair, (list, tuple)) and len(pair) == 2]


def nearest_of(candidates: Sequence[Gesture], at: float, within: float = 0.25) -> Gesture | None:
    """Return the gesture whose stroke is nearest to a time, if it is at most ``within`` seconds away."""
    best = min(candidates, key=lambda one: abs(one.at - at), default=None)
    return best if best is not None and abs(best.at - at) <= within else None


def nearest_gesture(motion: Motion, at: float, within: float = 0.25) -> Gesture | None:
    """Return :func:`nearest_of` of the gestures of a motion, without detecting all of them."""
    return nearest_of(find_gestures(motion, at, within), at, within)


def leading_hand(speed: np.ndarray) -> str:
    """Return the hand that makes a stroke, from the wrists' speeds ``(frames, 2)`` in it."""
    left, right = speed.max(0)
    if min(left, right) >= _BOTH_SHARE * max(left, right):
        return "both"
    return "left" if left > right else "right"


class _TimedNames:
    """Names, each with its time in seconds."""

    def __init__(self, named: Sequence[tuple[str, float]]):
        self.names = [name for name, _ in named]
        self.times = np.array([time for _, time in named])

    def near(self, at: float) -> str:
        """Return the name nearest to a time, if it is near enough to belong to it, else ""."""
        if not self.names:
            return ""
        off = np.abs(self.times - at)
        row = int(off.argmin())
        return self.names[row] if off[row] <= _MATCH_SECONDS else ""
