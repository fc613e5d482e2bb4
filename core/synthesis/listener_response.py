"""Head movements of a listener: nods as the other's phrases end, seldom a tilt or a glance aside.

Listeners nod two or three times at about 2 Hz and a few degrees (Hadar et al. 1985), most often as a phrase of the other ends
(Dittmann and Llewellyn 1968), and look at who speaks but for short glances (Kendon 1967)."""

from typing import NamedTuple

import numpy as np

from ..meaning.gesture_blending import rotate_about_axis
from ..motion import skeleton
from ..motion.interpolation import ramp
from ..smoothing import gaussian

HEAD = (1, 2)
"""Edges of the head."""
_SHARE = (0.4, 0.6)
"""Shares of a turn that neck and head take."""
_CHANCE = {"nod": 0.5, "tilt": 0.12, "glance": 0.12}
"""Probability of each response as a phrase of the other ends."""
_MIN_GAP = 1.8
"""Seconds between two responses."""
_DELAY = (-0.15, 0.35)
"""Seconds from the end of a phrase to the response."""
_NOD_DEGREES, _NOD_RATE, _NOD_COUNTS = (3.0, 8.0), (1.8, 2.6), (1, 2, 2, 3)
"""Degrees of a nod, nods a second, and nods in a row."""
_TILT_DEGREES, _TILT_SECONDS = (3.0, 7.0), (1.2, 3.0)
_GLANCE_DEGREES, _GLANCE_SECONDS = (8.0, 16.0), (0.7, 1.5)
_MAX_TURN, _SPEAKING_SHARE, _TURN_EASE = 55.0, 0.35, 0.35
"""Degrees that a head turns towards the other speaker, the share of them while it speaks itself, and the easing in seconds."""
_RAMP = 0.45
"""Seconds in which the head goes into a tilt or glance, and comes back."""


class Response(NamedTuple):
    """A ``kind`` of response (nod, tilt or glance): start and duration in seconds, signed degrees, and how many nods."""

    kind: str
    at: float
    degrees: float
    lasts: float
    times: int = 1


def draw_responses(phrases: np.ndarray, hears: np.ndarray, seed: int = 0, fps: float = skeleton.FPS) -> list[Response]:
    """Draw a listener's responses to the ends of another's ``phrases`` ``(p, 2)`` in seconds.

    ``hears`` ``(frames,)`` in 0..1 says how far it listens in each frame."""
    rng, responses, free = np.random.default_rng((seed, 0x115)), [], 0.0
    for _, end in np.asarray(phrases).reshape(-1, 2):
        at = float(end + rng.uniform(*_DELAY))
        kind = rng.choice([*_CHANCE, ""], p=[*_CHANCE.values(), 1 - sum(_CHANCE.values())])
        side, one = rng.choice([-1.0, 1.0]), None
        if kind == "nod":
            times = int(rng.choice(_NOD_COUNTS))
            one = Response("nod", at, rng.uniform(*_NOD_DEGREES), times / rng.uniform(*_NOD_RATE), times)
        elif kind:
            tilts = kind == "tilt"
            sizes, seconds = (_TILT_DEGREES, _TILT_SECONDS) if tilts else (_GLANCE_DEGREES, _GLANCE_SECONDS)
            one = Response(str(kind), at, side * rng.uniform(*sizes), rng.uniform(*seconds))
        row = min(int(max(at, 0) * fps), len(hears) - 1)
        if one is not None and at >= free and hears[row] > 0.5:
            responses.append(one)
            free = at + one.lasts + _MIN_GAP
    return responses


def apply_responses(
    directions: np.ndarray, answered: list[Response], hears: np.ndarray, fps: float = skeleton.FPS
) -> np.ndarray:
    """Add responses to the head of directions ``(frames, 9, 3)``, scaled by ``hears`` ``(frames,)`` in 0..1."""
    if not answered:
        return directions
    time = np.arange(len(directions)) / fps
    turns = np.zeros((3, len(time)))  # nods about x, glances about y, tilts about z
    for one in answered:
        if one.kind == "nod":
            through = np.clip((time - one.at) / one.lasts, 0, 1)
            turns[0] -= one.degrees * np.sin(np.pi * one.times * through) ** 2 * (1 - 0.4 * through) * (through < 1)
        else:
            end = one.at + one.lasts
            share = ramp(time, one.at, one.at + _RAMP) * (1 - ramp(time, end, end + _RAMP))
            turns[1 if one.kind == "glance" else 2] += one.degrees * share
    return _turn_head(directions, turns * gaussian(hears, 0.2 * fps))


def turn_head_toward(directions: np.ndarray, toward: float, hears: np.ndarray | None, fps: float = skeleton.FPS) -> np.ndarray:
    """Turn the head of directions ``(frames, 9, 3)`` by ``toward`` degrees to the left: wholly where it ``hears``
    ``(frames,)``, 0..1, else a little."""
    if not toward:
        return directions
    share = np.zeros(len(directions)) if hears is None else gaussian(hears, _TURN_EASE * fps)
    turns = np.zeros((3, len(directions)))
    turns[1] = -np.clip(toward, -_MAX_TURN, _MAX_TURN) * (_SPEAKING_SHARE + (1 - _SPEAKING_SHARE) * share)
    result, heads = directions.copy(), list(HEAD)
    result[:, heads] = _turn_head(directions, turns, (1.0, 0.0))[:, heads]  # all else stays to the bit
    return result


def _turn_head(directions: np.ndarray, turns: np.ndarray, shares: tuple = _SHARE) -> np.ndarray:
    """Turn neck and head by degrees ``(3, frames)`` about x, y and z."""
    result, total = directions.astype(float), 0.0
    for edge, share in zip(HEAD, shares, strict=True):
        total += share
        for axis in range(3):
            result[:, edge] = rotate_about_axis(result[:, edge], axis, total * turns[axis])
    return skeleton.normalize(result).astype(np.float32)
