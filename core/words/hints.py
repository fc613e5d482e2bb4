"""Applies the hints of a transcript: stress, pauses, gestures, size, side, rest, style."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..motion import rest, skeleton
from ..motion.interpolation import smoothstep
from .markup import Mark


class Hint(NamedTuple):
    """A hint that requests a gesture. ``meaning`` is its name in the corpora, for networks conditioned on strokes; ``word`` has
    this gesture and replaces the spoken word in the input of other networks."""

    word: str
    meaning: str


_TABLE = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
HINTS: dict[str, Hint] = {name: Hint(*one) for name, one in _TABLE.items()}
"""Hints that request a gesture."""
SIZES = {"big": 1.6, "bigger": 1.6, "large": 1.6, "small": 0.55, "smaller": 0.55, "calm": 0.55}
REST = ("none", "rest", "still")
SIDES = {"left": -1.0, "right": 1.0}

_STRESS_SCALE = 1.25
"""Factor by which gestures on stressed words are scaled."""
_RAMP_SECONDS = 0.45
"""Seconds over which an effect fades in and out."""
_OTHER_ARM_REST = 0.8
"""Share by which the other arm goes to the rest pose where a side is requested."""
_AS, _USUAL = "as", "usual"
"""``{as STYLE}`` starts a style, and ``{as usual}`` returns to the take's own."""
_STYLE_LEAD = 0.2
"""Seconds before the word at which a style starts."""
_GESTURE_LEAD = 0.5
"""Seconds around a word that its gesture takes."""


@dataclass(frozen=True)
class HintEffects:
    """Effects of all marks of a transcript; ``unknown`` are hints without a meaning.

    ``stressed`` are indices of words; ``gestures`` maps indices to the hint (of :data:`HINTS`) and side (-1 left, 1 right,
    0 either) of a gesture; ``rests`` are ``(start, end)``, ``sizes`` and ``sides`` ``(start, end, value)``, in seconds.
    ``styles`` are ``(start, name)``, with an empty name for the take's own style."""

    stressed: frozenset[int] = frozenset()
    gestures: dict[int, tuple[str, float]] = field(default_factory=dict)
    sizes: tuple[tuple[float, float, float], ...] = ()
    sides: tuple[tuple[float, float, float], ...] = ()
    rests: tuple[tuple[float, float], ...] = ()
    unknown: tuple[str, ...] = ()
    styles: tuple[tuple[float, str], ...] = ()

    @property
    def shapes_motion(self) -> bool:
        """Whether :func:`apply_hints` changes the motion."""
        return bool(self.sizes or self.sides or self.rests)


def parse_hints(marks: Sequence[Mark], words: Sequence[tuple[str, float, float]]) -> HintEffects:
    """Return the effects of marks, whose indices refer to ``words`` ``(text, start, end)``."""
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
            styles.append((max(start - _STYLE_LEAD, 0.0), "" if name == _USUAL else name))
        elif mark.value in REST:
            rests.append((start, end))
        elif mark.value in SIZES:
            sizes.append((start, end, SIZES[mark.value]))
        elif names[-1] in SIDES and (len(names) == 1 or " ".join(names[:-1]) in HINTS):
            gestures[mark.first] = " ".join(names[:-1]) or "point", SIDES[names[-1]]
            stressed.add(mark.first)
            sides.append((start - _GESTURE_LEAD, words[mark.first][2] + _GESTURE_LEAD, SIDES[names[-1]]))
        elif mark.value in HINTS:
            gestures[mark.first] = mark.value, 0.0
            stressed.add(mark.first)
        else:
            unknown.append(mark.value)
    sizes += [(words[number][1], words[number][2], _STRESS_SCALE) for number in sorted(stressed)]
    spans = tuple(sizes), tuple(sides), tuple(rests)
    return HintEffects(frozenset(stressed), gestures, *spans, tuple(dict.fromkeys(unknown)), tuple(styles))


def network_words(
    words: Sequence[tuple[str, float, float]], wishes: HintEffects, understood: bool = True, asked: frozenset[int] = frozenset()
) -> list[tuple[str, float, float]]:
    """Return the words as input of the network: empty texts where the language is not ``understood``.

    A gesture hint replaces its word by one that has the gesture, except at the indices in ``asked``, where the network is
    conditioned on a stroke."""
    replaced = {number: HINTS[hint].word for number, (hint, _) in wishes.gestures.items() if number not in asked}
    spoken = [(text if understood else "", start, end) for text, start, end in words]
    return [(replaced.get(number, text), start, end) for number, (text, start, end) in enumerate(spoken)]


def apply_hints(directions: np.ndarray, wishes: HintEffects, pose: np.ndarray) -> np.ndarray:
    """Apply the sizes, sides and rests of hints to edge directions ``(frames, 9, 3)`` at 15 fps; all else stays bit-identical.

    ``pose`` is the rest pose, ``(9, 3)``, or ``(frames, 9, 3)`` if it changes over time."""
    if not wishes.shapes_motion:
        return directions
    time = np.arange(len(directions)) / skeleton.FPS
    for start, end, side in wishes.sides:
        directions = _lead_with(directions, envelope(time, start, end), side, pose)
    size = np.ones(len(time))
    for start, end, value in wishes.sizes:
        size *= 1 + (value - 1) * envelope(time, start, end)
    directions = rest.scale_amplitude(directions, size, pose)
    rest_weight = np.zeros(len(time))
    for start, end in wishes.rests:
        rest_weight = np.maximum(rest_weight, envelope(time, start, end))
    return rest.slerp(directions, pose, rest_weight[:, None]).astype(np.float32) if rest_weight.any() else directions


def envelope(time: np.ndarray, start: float, end: float) -> np.ndarray:
    """Return weights that are 1 from ``start`` to ``end`` seconds and ease to 0 within half a second outside."""
    outside = np.maximum(np.maximum(start - time, time - end), 0) / _RAMP_SECONDS
    return smoothstep(1 - outside)


def _lead_with(directions: np.ndarray, weight: np.ndarray, side: float, pose: np.ndarray) -> np.ndarray:
    """Let the arm of ``side`` lead: mirror the motion where the other arm moves more, and blend that arm toward ``pose``."""
    lift = np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))
    left, right = ((weight[:, None] * lift[:, list(arm)]).sum() for arm in skeleton.ARMS)
    if (right - left) * side < 0:
        directions = rest.slerp(directions, skeleton.mirror(directions), weight[:, None])
    other = list(skeleton.ARMS[side < 0])
    result = directions.astype(np.float32)
    result[:, other] = rest.slerp(result[:, other], np.asarray(pose)[..., other, :], _OTHER_ARM_REST * weight[:, None])
    return result
