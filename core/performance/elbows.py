"""Elbows that are held up like wings, with the hand below, sink: the arm is turned about the line from shoulder to wrist, so
that the hand stays where it was. People's elbows are so high where the hand is higher still.
"""

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian
from . import keeping, trunk

_HIGH, _SOON = 0.15, 0.06
"""Metres below the shoulder above which an elbow is too high, and over how many more it is led back."""
_BELOW, _OVER = -0.04, 0.1
"""Metres below the elbow from which on a hand is so low that this holds wholly, and over how many it sets in."""
_BRIEF = 0.13
"""Seconds, the width of the Gaussian by which that comes and goes."""
_LEAST = 0.02
"""Metres from that line at which an elbow can be turned at all."""


def lowered(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 without elbows like wings.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    points = skeleton.to_positions(directions).astype(float)
    free = keeping.free(len(result), given)
    for side, (upper, lower) in enumerate(skeleton.ARMS):
        joints = (skeleton.EDGES[upper][0], *(skeleton.EDGES[edge][1] for edge in (upper, lower)))
        shoulder, elbow, wrist = (points[:, joint] for joint in joints)
        down = trunk.axes(directions, points, side)[2]
        below, hangs = (trunk.along(way, down)[0] for way in (elbow - shoulder, wrist - elbow))
        high = np.maximum(_HIGH - below, 0) * np.clip((hangs - _BELOW) / _OVER + 1, 0, 1)
        if not high.any():
            continue
        axis = skeleton.normalize(wrist - shoulder)
        angle = gaussian(_angle(elbow - shoulder, axis, down, high**2 / (high + _SOON)), _BRIEF * skeleton.FPS) * free
        here = np.flatnonzero(angle)
        for edge in (upper, lower):
            result[here, edge] = _turned(directions[here, edge].astype(float), axis[here], angle[here])
    return result


def _angle(elbow: np.ndarray, axis: np.ndarray, down: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Radians ``(frames,)`` about an ``axis`` by which elbows, seen from their shoulders, sink by the ``wanted`` metres, or as
    far as they can.
    """
    aside, low = (vectors - trunk.along(vectors, axis)[0][:, None] * axis for vectors in (elbow, down))
    across = np.cross(axis, low)
    x, y = trunk.along(aside, low, across)
    size = np.hypot(x, y)
    now = np.arctan2(y, x)
    room = np.linalg.norm(aside, axis=-1) * np.linalg.norm(low, axis=-1)
    there = np.arccos(np.clip(np.cos(now) + wanted / np.maximum(room, _LEAST), -1, 1))
    return np.where(size > _LEAST * np.linalg.norm(low, axis=-1), np.sign(now) * there - now, 0.0)


def _turned(vectors: np.ndarray, axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Unit vectors ``(n, 3)`` turned about an ``axis`` by radians ``(n,)`` (Rodrigues)."""
    along = trunk.along(vectors, axis)[0][:, None] * axis
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return along + cos * (vectors - along) + sin * np.cross(axis, vectors)
