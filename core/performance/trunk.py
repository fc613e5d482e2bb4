"""What lies where about a body's trunk, and arms that are turned about its axis."""

import numpy as np

from ..motion import skeleton

PALM = 0.08
"""Metres from the wrist to the palm."""
_ASIDE = 0.998


def axes(directions: np.ndarray, points: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors ``(frames, 3)`` out to an arm's side, to the front and down, of directions and their positions."""
    up = skeleton.normalize(directions[:, 0].astype(float))
    near, far = (points[:, skeleton.EDGES[upper][0]] for upper, _ in (skeleton.ARMS[side], skeleton.ARMS[1 - side]))
    wide = near - far
    out = skeleton.normalize(wide - (wide * up).sum(-1, keepdims=True) * up)
    return out, np.cross(out, -up) * (1 if side else -1), -up


def along(vectors: np.ndarray, *axes: np.ndarray) -> list[np.ndarray]:
    """How far ``(frames,)`` vectors ``(frames, 3)`` go along each of the axes."""
    return [(vectors * axis).sum(-1) for axis in axes]


def outwards(aside: np.ndarray, ahead: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Radians by which what is so far aside and ahead of a shoulder turns to be ``wanted`` far aside, metres."""
    # Of an arm that points straight aside a little less says nothing of how far it is turned.
    long = np.maximum(np.hypot(aside, ahead), 1e-6)
    return np.subtract(*(np.arcsin(np.clip(place / long, -_ASIDE, _ASIDE)) for place in (wanted, aside)))


def turned(vectors: np.ndarray, out: np.ndarray, front: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Vectors ``(frames, 3)`` turned from ``front`` towards ``out``, by radians ``(frames,)``."""
    a, b = along(vectors, out, front)
    more = np.cos(turn) - 1
    return vectors + (a * more + b * np.sin(turn))[:, None] * out + (b * more - a * np.sin(turn))[:, None] * front
