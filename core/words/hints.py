"""A transcript's hints as changes to the performance: stress, pauses, gestures, size, side, rest, style."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..motion import rest, skeleton
from .markup import Mark


class Hint(NamedTuple):
    """What a hint asks for: the ``word`` whose gesture it is, which a network that cannot be asked for strokes hears instead of
    the one that is said, and the ``meaning`` of that stroke, as corpora name it, for networks that can.
    """

    word: str
    meaning: str


HINTS = {
    "me": Hint("me", "me"), "you": Hint("you", "you"), "we": Hint("we", "we"), "us": Hint("we", "we"),
    "not": Hint("not", "not"), "no": Hint("not", "not"), "all": Hint("everything", "all"),
    "every": Hint("everything", "all"), "question": Hint("what", "question"), "stop": Hint("stop", "stop"),
    "wait": Hint("wait", "stop"), "here": Hint("here", "here"), "there": Hint("there", "there"),
    "point": Hint("there", "there"), "think": Hint("think", "think"), "maybe": Hint("maybe", "maybe"),
    "please": Hint("please", "please"), "offer": Hint("give", "offer"), "give": Hint("give", "offer"),
    "take": Hint("get", "receive"), "list": Hint("first", "list"), "one": Hint("one", "count"), "two": Hint("two", "count"),
    "three": Hint("three", "count"), "thing": Hint("thing", "thing"), "example": Hint("example", "example"),
    "but": Hint("but", "however"), "huge": Hint("huge", "big"), "wide": Hint("huge", "big"), "never": Hint("never", "not"),
}  # fmt: skip
"""Hints that ask for a gesture."""
SIZES = {"big": 1.6, "bigger": 1.6, "large": 1.6, "small": 0.55, "smaller": 0.55, "calm": 0.55}
REST = ("none", "rest", "still")
SIDES = {"left": -1.0, "right": 1.0}

_STRESSED = 1.25
"""How much larger a gesture is on a stressed word."""
_RAMP = 0.45
"""Seconds in which a wish comes and goes."""
_HELD_BACK = 0.8
"""How far the other arm goes to rest where a side was asked for."""
_AS, _USUAL = "as", "usual"
"""``{as STYLE}`` begins a style, and ``{as usual}`` the take's own again,"""
_TURNS = 0.2
"""so many seconds before the word."""
_LEAD = 0.5
"""Seconds before a word in which its gesture is prepared."""


@dataclass(frozen=True)
class Wishes:
    """Marks that are understood, for ``words`` ``(text, start, end)``; ``unknown`` are hints that mean nothing here.

    ``stressed`` are numbers of words, ``gestures`` maps some to the hint (of :data:`HINTS`) and the side (-1 left, 1
    right, 0 either) of what is to be seen there; ``rests`` are spans and the others ``(start, end, value)``, in seconds.
    ``styles`` begin at ``(seconds, name)``, without a name the take's own.
    """

    stressed: frozenset[int] = frozenset()
    gestures: dict[int, tuple[str, float]] = field(default_factory=dict)
    sizes: tuple[tuple[float, float, float], ...] = ()
    sides: tuple[tuple[float, float, float], ...] = ()
    rests: tuple[tuple[float, float], ...] = ()
    unknown: tuple[str, ...] = ()
    styles: tuple[tuple[float, str], ...] = ()

    @property
    def shapes_motion(self) -> bool:
        """Whether the finished motion is to be changed."""
        return bool(self.sizes or self.sides or self.rests)


def understand(marks: Sequence[Mark], words: Sequence[tuple[str, float, float]]) -> Wishes:
    """Wishes of marks whose numbers count ``words``."""
    stressed, gestures, sizes, sides, rests, unknown, styles = set(), {}, [], [], [], [], []
    for mark in marks:
        if mark.kind == "pause":
            if 0 < mark.first < len(words):
                rests.append((words[mark.first - 1][2], words[mark.first][1]))
            continue
        start, end = words[mark.first][1], words[min(mark.last, len(words)) - 1][2]
        names = mark.value.split()
        if mark.kind == "stress":
            stressed.add(mark.first)
        elif names[0] == _AS and len(names) > 1:
            name = " ".join(names[1:])
            styles.append((max(start - _TURNS, 0.0), "" if name == _USUAL else name))
        elif mark.value in REST:
            rests.append((start, end))
        elif mark.value in SIZES:
            sizes.append((start, end, SIZES[mark.value]))
        elif names[-1] in SIDES and (len(names) == 1 or " ".join(names[:-1]) in HINTS):
            gestures[mark.first] = " ".join(names[:-1]) or "point", SIDES[names[-1]]
            stressed.add(mark.first)
            sides.append((start - _LEAD, words[mark.first][2] + _LEAD, SIDES[names[-1]]))
        elif mark.value in HINTS:
            gestures[mark.first] = mark.value, 0.0
            stressed.add(mark.first)
        else:
            unknown.append(mark.value)
    sizes += [(words[number][1], words[number][2], _STRESSED) for number in sorted(stressed)]
    spans = tuple(sizes), tuple(sides), tuple(rests)
    return Wishes(frozenset(stressed), gestures, *spans, tuple(dict.fromkeys(unknown)), tuple(styles))


def heard(
    words: Sequence[tuple[str, float, float]], wishes: Wishes, understood: bool = True, asked: frozenset[int] = frozenset()
) -> list[tuple[str, float, float]]:
    """Return the words as network input: those of a language that is not ``understood`` as unknown ones.

    A hint replaces its word by the one that has the gesture, except at the words whose numbers are in ``asked``.
    """
    instead = {number: HINTS[hint].word for number, (hint, _) in wishes.gestures.items() if number not in asked}
    spoken = [(text if understood else "", start, end) for text, start, end in words]
    return [(instead.get(number, text), start, end) for number, (text, start, end) in enumerate(spoken)]


def perform(directions: np.ndarray, wishes: Wishes, pose: np.ndarray) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` at 15 fps with sizes, sides and rests as wished, and all else as it was to the bit.

    ``pose`` is rest, ``(9, 3)``, or ``(frames, 9, 3)`` where it changes on the way.
    """
    if not wishes.shapes_motion:
        return directions
    time = np.arange(len(directions)) / skeleton.FPS
    for start, end, side in wishes.sides:
        directions = _sided(directions, envelope(time, start, end), side, pose)
    size = np.ones(len(time))
    for start, end, value in wishes.sizes:
        size *= 1 + (value - 1) * envelope(time, start, end)
    directions = rest.scale(directions, size, pose)
    still = np.zeros(len(time))
    for start, end in wishes.rests:
        still = np.maximum(still, envelope(time, start, end))
    return rest.slerp(directions, pose, still[:, None]).astype(np.float32) if still.any() else directions


def envelope(time: np.ndarray, start: float, end: float) -> np.ndarray:
    """1 between two moments, easing to 0 within half a second outside."""
    outside = np.maximum(np.maximum(start - time, time - end), 0) / _RAMP
    share = np.clip(1 - outside, 0, 1)
    return share * share * (3 - 2 * share)


def _sided(directions: np.ndarray, weight: np.ndarray, side: float, pose: np.ndarray) -> np.ndarray:
    """The hand of the wished side leads: the mirror image where the other arm does more, and that arm held back."""
    lift = np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))
    left, right = ((weight[:, None] * lift[:, list(arm)]).sum() for arm in skeleton.ARMS)
    if (right - left) * side < 0:
        directions = rest.slerp(directions, skeleton.mirror(directions), weight[:, None])
    other = list(skeleton.ARMS[side < 0])
    result = directions.astype(np.float32)
    result[:, other] = rest.slerp(result[:, other], np.asarray(pose)[..., other, :], _HELD_BACK * weight[:, None])
    return result
