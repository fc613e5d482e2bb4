"""Arms that are drawn across the chest or straight out to the side come back before it: people reach so far for their
other shoulder or to measure themselves, not to talk.

Low hands may fold, cross and hang as they like.
"""

import numpy as np

from ..motion import skeleton
from . import keeping, trunk

_FREE, _WIDE, _SOON, _SHARE = 0.06, 0.37, 0.05, 0.75
"""Metres beyond the body's middle that a wrist may be, and away from its own shoulder (98 % of the frames of captured clips
stay within); over how many more it is taken back, and how much of the rest."""
_HIGH, _LOW = 0.16, 0.34
"""Metres below the shoulder at which that holds wholly, and not at all."""


def brought_back(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 whose arms are turned about the trunk's axis, as far as their wrists are across.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    free = keeping.free(len(result), given)
    points = skeleton.to_positions(directions).astype(float)
    for side, (upper, lower) in enumerate(skeleton.ARMS):
        out, front, down = trunk.axes(directions, points, side)
        shoulder, other = (points[:, skeleton.EDGES[arm[0]][0]] for arm in (skeleton.ARMS[side], skeleton.ARMS[1 - side]))
        wrist = points[:, skeleton.EDGES[lower][1]]
        turn = free * _turn(*trunk.along(wrist - shoulder, out, front, down), 0.5 * np.linalg.norm(shoulder - other, axis=-1))
        for edge in (upper, lower):
            result[:, edge] = trunk.turned(directions[:, edge].astype(float), out, front, turn)
    return result


def _turn(aside: np.ndarray, ahead: np.ndarray, below: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Radians by which an arm is turned outwards, of where its wrist is from the shoulder, metres."""
    across, wide = np.maximum(-(aside + half) - _FREE, 0), np.maximum(aside - _WIDE, 0)
    wanted = aside + _SHARE * (across**2 / (across + _SOON) - wide**2 / (wide + _SOON))
    share = np.clip((_LOW - below) / (_LOW - _HIGH), 0, 1)
    angle = trunk.outwards(aside, ahead, wanted)
    return np.where((ahead > 0) | (aside > 0), angle * share * share * (3 - 2 * share), 0.0)
