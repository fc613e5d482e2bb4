"""Detects the gestures of a take: the phases of each (preparation, stroke, hold, release), its hand, size and word."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..motion import skeleton
from ..motion.motion import Motion
from ..sound import peaks

SPEED, PROMINENCE, APART = 0.25, 0.15, 0.4
"""A stroke is a peak of the faster wrist's speed: its least height and prominence in m/s, and least distance to others in s."""
BEAT = "beat"
"""Kind of a gesture that follows the rhythm of speech and has no meaning of its own."""
HANDS = ("left", "right", "both")

_STROKE_SHARE = 0.3
"""Share of the peak speed above which a frame belongs to the stroke."""
_MOVING_SPEED = 0.12
"""Wrist speed in m/s above which a frame belongs to preparation or release."""
_BOTH_SHARE = 0.55
"""Share of the faster wrist's speed from which the slower hand takes part in the gesture."""
_MAX_PREPARATION, _MAX_RELEASE = 0.8, 0.9
"""Longest preparation and release in seconds."""
_MATCH_SECONDS = 0.35
"""Largest distance in time between a stroke and the word or semantic gesture that belongs to it."""


@dataclass(frozen=True)
class Gesture:
    """A gesture of a take. Its times are in seconds and in order.

    The preparation starts at ``begin``, the stroke at ``stroke`` with its peak of speed ``at``, the hold at ``hold``, the
    release at ``release``; it is over at ``end``. ``hand`` is one of :data:`HANDS`, ``kind`` a semantic gesture
    (:mod:`vocabulary`) or :data:`BEAT`, ``size`` the path of the leading wrist in the stroke in metres, ``word`` the word
    that is spoken meanwhile, or "".
    """

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


def wrist_speeds(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the speeds of the wrists ``(frames, 2)`` in metres per second, of directions ``(frames, 9, 3)``."""
    if len(directions) < 2:
        return np.zeros((len(directions), 2))
    return np.linalg.norm(np.gradient(skeleton.wrists(directions), axis=0), axis=-1) * fps


def find_gestures(motion: Motion, around: float | None = None, within: float = 0.25) -> list[Gesture]:
    """Return the gestures of a motion in order of time.

    If ``around`` is given, only those whose strokes are at most ``within`` seconds (and one frame) away from it.
    """
    names = _TimedNames(meant_gestures(motion))
    words = _TimedNames([(word, 0.5 * (start + end)) for word, start, end in motion.words])
    speed, fps = wrist_speeds(motion.directions, motion.fps), motion.fps
    faster = speed.max(1)
    places = _stroke_places(faster, fps)
    faster = faster.tolist()
    rows = list(range(len(places)))
    if around is not None:
        rows = [row for row in rows if abs(places[row] / fps - around) <= within + 1 / fps]
        first, last = (max(rows[0] - 1, 0), rows[-1] + 2) if rows else (0, 0)
        places, rows = places[first:last], [row - first for row in rows]
    spans = [_stroke(faster, place) for place in places]
    detected = []
    for row in rows:
        place, (start, hold) = places[row], spans[row]
        before = spans[row - 1][1] if row else 0
        after = spans[row + 1][0] if row + 1 < len(spans) else len(faster) - 1
        begin = _preparation_start(faster, start, max(before, start - round(_MAX_PREPARATION * fps)))
        release, end = _release(faster, hold, max(after, hold), round(_MAX_RELEASE * fps))
        at = (place + _peak_offset(faster, place)) / fps
        hand = leading_hand(speed[start : hold + 1])
        size = float(speed[start : hold + 1].sum(0).max() / fps)
        kind, word = names.near(at) or BEAT, words.near(at)
        phases = begin / fps, start / fps, at, hold / fps, release / fps, end / fps
        detected.append(Gesture(*phases, hand, kind, size, word))
    return detected


def stroke_times(directions: np.ndarray, fps: float = skeleton.FPS) -> list[float]:
    """Return the seconds of the strokes of directions ``(frames, 9, 3)``, as :func:`find_gestures` finds them."""
    faster = wrist_speeds(directions, fps).max(1)
    return [(place + _peak_offset(faster.tolist(), place)) / fps for place in _stroke_places(faster, fps)]


def _stroke_places(faster: np.ndarray, fps: float) -> list[int]:
    """Return the frames of strokes: peaks of the faster wrist's speed ``(frames,)``."""
    places = [] if len(faster) < 3 else peaks.find_peaks(faster, PROMINENCE, round(APART * fps), 0.5).places
    return [int(place) for place in places if faster[place] > SPEED]


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


def _stroke(faster: list[float], place: int) -> tuple[int, int]:
    """Return the first and last frame of the stroke around a peak."""
    least, start, hold = _STROKE_SHARE * faster[place], place, place
    while start > 0 and faster[start] > least and faster[start - 1] < faster[start]:
        start -= 1
    while hold < len(faster) - 1 and faster[hold] > least and faster[hold + 1] < faster[hold]:
        hold += 1
    return start, hold


def _preparation_start(faster: list[float], start: int, first: int) -> int:
    """Return the frame at which the preparation of a stroke starts, not before ``first``."""
    while start > first and faster[start - 1] > _MOVING_SPEED:
        start -= 1
    return start


def _release(faster: list[float], hold: int, last: int, longest: int) -> tuple[int, int]:
    """Return the frames at which the release after a hold starts and ends: by ``last``, and in at most ``longest`` frames."""
    release = hold
    while release < last and (faster[release] <= _MOVING_SPEED or faster[release + 1] < faster[release]):
        release += 1
    end = release
    while end < min(last, release + longest) and faster[end] > _MOVING_SPEED:
        end += 1
    return release, end


def _peak_offset(values: list[float], place: int) -> float:
    """Return the offset in frames of a peak between samples, by a parabola through it and its neighbours."""
    before, here, after = values[place - 1 : place + 2]
    bend = before - 2 * here + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0


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
