"""The gestures of a take: when each is prepared, made, held and released, by which hand, how large, at which word."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..motion import skeleton
from ..motion.motion import Motion
from ..sound import peaks

SPEED, PROMINENCE, APART = 0.25, 0.15, 0.4
"""A stroke is a peak of the faster wrist's speed above this (m/s), that stands out so much (m/s), so far (s) from others."""
BEAT = "beat"
"""Kind of a gesture that goes with the voice and means nothing of its own."""
HANDS = ("left", "right", "both")

_STROKE = 0.3
"""Share of its highest speed above which a wrist still makes the stroke."""
_MOVING = 0.12
"""Metres a second above which a wrist prepares or releases."""
_BOTH = 0.55
"""Share of the faster wrist's speed from which on both hands make a gesture."""
_PREPARED, _RELEASED = 0.8, 0.9
"""Seconds that preparation and release have at most."""
_SAME = 0.08
"""Seconds between strokes of two takes up to which they are the same one."""
_BESIDE = 2.5
"""Seconds from a gesture within which what is done to it may change others."""
_SAID = 0.35
"""Seconds between a stroke and a word, or what it shows, within which they belong together."""


@dataclass(frozen=True)
class Gesture:
    """Seconds in order: preparation from ``begin``, stroke from ``stroke`` with its peak of speed ``at``, held from ``hold``,
    released from ``release``, over at ``end``.

    ``hand`` is one of :data:`HANDS`, ``kind`` the name of what it shows (:mod:`vocabulary`) or :data:`BEAT`, ``size`` the
    metres that the leading wrist goes in the stroke, ``word`` what is said meanwhile, or "".
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


def speeds(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Speeds of the wrists ``(frames, 2)`` in metres a second."""
    if len(directions) < 2:
        return np.zeros((len(directions), 2))
    return np.linalg.norm(np.gradient(skeleton.wrists(directions), axis=0), axis=-1) * fps


def find(motion: Motion, around: float | None = None, within: float = 0.25) -> list[Gesture]:
    """The gestures of a motion in order of time; only those whose strokes are ``within`` so many seconds of ``around``, or a
    frame more, if that is given.
    """
    speed, fps = speeds(motion.directions, motion.fps), motion.fps
    faster = speed.max(1)
    places = [] if len(speed) < 3 else peaks.find(faster, PROMINENCE, round(APART * fps), 0.5).places
    places = [place for place in places if faster[place] > SPEED]
    faster = faster.tolist()
    asked = range(len(places))
    if around is not None:
        asked = [row for row in asked if abs(places[row] / fps - around) <= within + 1 / fps]
        first, last = (max(asked[0] - 1, 0), asked[-1] + 2) if asked else (0, 0)
        places, asked = places[first:last], [row - first for row in asked]
    spans = [_stroke(faster, place) for place in places]
    names = _Named(shows(motion))
    words = _Named([(word, 0.5 * (start + end)) for word, start, end in motion.words])
    found = []
    for row in asked:
        place, (start, hold) = places[row], spans[row]
        before = spans[row - 1][1] if row else 0
        after = spans[row + 1][0] if row + 1 < len(spans) else len(faster) - 1
        begin = _back(faster, start, max(before, start - round(_PREPARED * fps)))
        release, end = _released(faster, hold, max(after, hold), round(_RELEASED * fps))
        at = (place + _summit(faster, place)) / fps
        hand = leading(speed[start : hold + 1])
        size = float(speed[start : hold + 1].sum(0).max() / fps)
        times = [frame / fps for frame in (begin, start, hold, release, end)]
        found.append(Gesture(*times[:2], at, *times[2:], hand, names.near(at) or BEAT, size, words.near(at)))
    return found


def spoken(word: str) -> str:
    """A word of a transcript as edits name it: in lower case, without marks."""
    return word.lower().strip(".,;:!?\"'()…-–—")


def shows(motion: Motion) -> list[tuple[str, float]]:
    """What a motion's provenance says that it shows: names and the seconds at which strokes land."""
    told = motion.meta.get("shows")
    pairs = told if isinstance(told, list) else []
    return [(str(one[0]), float(one[1])) for one in pairs if isinstance(one, (list, tuple)) and len(one) == 2]


def near(found: Sequence[Gesture], at: float, within: float = 0.25) -> Gesture | None:
    """The gesture whose stroke is nearest to a time, if it is ``within`` so many seconds."""
    best = min(found, key=lambda one: abs(one.at - at), default=None)
    return best if best is not None and abs(best.at - at) <= within else None


def nearest(motion: Motion, at: float, within: float = 0.25) -> Gesture | None:
    """:func:`near` of what :func:`find` finds in a motion, in less time."""
    return near(find(motion, at, within), at, within)


def left(motion: Motion, deleted: Gesture, others: Sequence[Gesture]) -> float:
    """Metres of the stroke that is where another one was deleted, but for ``others`` that stayed where they were."""
    stayed = [one for one in find(motion) if near(others, one.at, _SAME) is None]
    one = near(stayed, deleted.at, deleted.hold - deleted.stroke)
    return 0.0 if one is None else one.size


def disturbed(motion: Motion, deleted: Gesture, others: Sequence[Gesture]) -> int:
    """How many of the ``others`` near a deleted gesture do not make their stroke where they made it, and how many are new."""
    now = [one for one in find(motion, deleted.at, _BESIDE) if abs(one.at - deleted.at) > deleted.hold - deleted.stroke]
    near_by = [one for one in others if abs(one.at - deleted.at) <= _BESIDE]
    lost = sum(near(now, one.at, _SAME) is None for one in near_by)
    return lost + max(len(now) - len(near_by) + lost, 0)


def leading(speed: np.ndarray) -> str:
    """The hand that makes a stroke, of the wrists' speeds ``(frames, 2)`` in it."""
    left, right = speed.max(0)
    if min(left, right) >= _BOTH * max(left, right):
        return "both"
    return "left" if left > right else "right"


def _stroke(faster: list[float], place: int) -> tuple[int, int]:
    """First and last frame of the stroke around a peak."""
    least, start, hold = _STROKE * faster[place], place, place
    while start > 0 and faster[start] > least and faster[start - 1] < faster[start]:
        start -= 1
    while hold < len(faster) - 1 and faster[hold] > least and faster[hold + 1] < faster[hold]:
        hold += 1
    return start, hold


def _back(faster: list[float], start: int, least: int) -> int:
    while start > least and faster[start - 1] > _MOVING:
        start -= 1
    return start


def _released(faster: list[float], hold: int, most: int, longest: int) -> tuple[int, int]:
    release = hold
    while release < most and (faster[release] <= _MOVING or faster[release + 1] < faster[release]):
        release += 1
    end = release
    while end < min(most, release + longest) and faster[end] > _MOVING:
        end += 1
    return release, end


def _summit(values: list[float], place: int) -> float:
    """Where the parabola through a peak and its neighbours is highest, in frames from it."""
    before, here, after = values[place - 1 : place + 2]
    bend = before - 2 * here + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0


class _Named:
    """Names, each with its seconds."""

    def __init__(self, named: Sequence[tuple[str, float]]):
        self.names = [name for name, _ in named]
        self.times = np.array([time for _, time in named])

    def near(self, at: float) -> str:
        """The name nearest to a time that belongs to what is done then, or ""."""
        if not self.names:
            return ""
        off = np.abs(self.times - at)
        row = int(off.argmin())
        return self.names[row] if off[row] <= _SAID else ""
