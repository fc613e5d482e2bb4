"""What somebody does who listens: nods as phrases end, now and then a tilt of the head or a glance aside; few and small.

Listeners nod two or three times at about 2 Hz and a few degrees (Hadar et al. 1985), most often as a phrase of the other ends
(Dittmann and Llewellyn 1968), and look at who speaks but for short glances (Kendon 1967).
"""

from typing import NamedTuple

import numpy as np

from ..meaning.showing import turned
from ..motion import skeleton
from ..motion.curves import ramp
from ..smoothing import gaussian

HEAD = (1, 2)
"""Edges of the head."""
_SHARE = (0.4, 0.6)
"""Shares of a turn that the neck and the head above it take; both are turned by what lies below."""
_CHANCE = {"nod": 0.5, "tilt": 0.12, "glance": 0.12}
"""Chance of each as a phrase of the other ends."""
_APART = 1.8
"""Seconds between two of them at least."""
_AFTER = (-0.15, 0.35)
"""Seconds from the end of a phrase to its answer."""
_NOD, _RATE, _TIMES = (3.0, 8.0), (1.8, 2.6), (1, 2, 2, 3)
"""Degrees of a nod, how many a second, and how many in a row."""
_TILT, _TILTED = (3.0, 7.0), (1.2, 3.0)
_GLANCE, _AWAY = (8.0, 16.0), (0.7, 1.5)
"""Degrees, and seconds for which the head is there."""
_FARTHEST, _SPEAKING, _COMES = 55.0, 0.35, 0.35
"""Degrees that a head turns to whom it listens to, the share of them while it speaks itself, seconds in which it comes."""
_TURNS = 0.45
"""Seconds in which it goes there and back."""


class Answer(NamedTuple):
    """``kind`` (nod, tilt or glance), from ``at`` on in seconds, signed degrees, how long it ``lasts``, ``times`` of a nod."""

    kind: str
    at: float
    degrees: float
    lasts: float
    times: int = 1


def answers(phrases: np.ndarray, hears: np.ndarray, seed: int = 0, fps: float = skeleton.FPS) -> list[Answer]:
    """What a listener does as another's ``phrases`` ``(p, 2)`` in seconds end, where it ``hears`` ``(frames,)``, 0..1."""
    rng, found, free = np.random.default_rng((seed, 0x115)), [], 0.0
    for _, end in np.asarray(phrases).reshape(-1, 2):
        at = float(end + rng.uniform(*_AFTER))
        kind = rng.choice([*_CHANCE, ""], p=[*_CHANCE.values(), 1 - sum(_CHANCE.values())])
        side, one = rng.choice([-1.0, 1.0]), None
        if kind == "nod":
            times = int(rng.choice(_TIMES))
            one = Answer("nod", at, rng.uniform(*_NOD), times / rng.uniform(*_RATE), times)
        elif kind:
            sizes, long = (_TILT, _TILTED) if kind == "tilt" else (_GLANCE, _AWAY)
            one = Answer(str(kind), at, side * rng.uniform(*sizes), rng.uniform(*long))
        row = min(int(max(at, 0) * fps), len(hears) - 1)
        if one is not None and at >= free and hears[row] > 0.5:
            found.append(one)
            free = at + one.lasts + _APART
    return found


def perform(directions: np.ndarray, answered: list[Answer], hears: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` whose head answers, as far as it ``hears`` ``(frames,)`` 0..1; all else is as it was."""
    if not answered:
        return directions
    time = np.arange(len(directions)) / fps
    turns = np.zeros((3, len(time)))  # nodding, looking aside, tilting: about x, y and z
    for one in answered:
        if one.kind == "nod":
            through = np.clip((time - one.at) / one.lasts, 0, 1)
            turns[0] -= one.degrees * np.sin(np.pi * one.times * through) ** 2 * (1 - 0.4 * through) * (through < 1)
        else:
            there = ramp(time, one.at, one.at + _TURNS) * (1 - ramp(time, one.at + one.lasts, one.at + one.lasts + _TURNS))
            turns[1 if one.kind == "glance" else 2] += one.degrees * there
    return _turned(directions, turns * gaussian(hears, 0.2 * fps))


def facing(directions: np.ndarray, toward: float, hears: np.ndarray | None, fps: float = skeleton.FPS) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` whose head is turned to somebody ``toward`` degrees on the left: wholly where it ``hears``
    ``(frames,)`` 0..1, else a little.
    """
    if not toward:
        return directions
    share = np.zeros(len(directions)) if hears is None else gaussian(hears, _COMES * fps)
    turns = np.zeros((3, len(directions)))
    turns[1] = -np.clip(toward, -_FARTHEST, _FARTHEST) * (_SPEAKING + (1 - _SPEAKING) * share)
    result, heads = directions.copy(), list(HEAD)
    result[:, heads] = _turned(directions, turns, (1.0, 0.0))[:, heads]  # all else stays to the bit
    return result


def _turned(directions: np.ndarray, turns: np.ndarray, shares: tuple = _SHARE) -> np.ndarray:
    """Directions whose head is turned by degrees ``(3, frames)`` about x, y and z, to its right."""
    result, total = directions.astype(float), 0.0
    for edge, share in zip(HEAD, shares, strict=True):
        total += share
        for axis in range(3):
            result[:, edge] = turned(result[:, edge], axis, total * turns[axis])
    return skeleton.normalize(result).astype(np.float32)
