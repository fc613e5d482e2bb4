"""Hands that hide the face, or are past it so that a forearm does, go to its side, however briefly: people hardly ever pass
there while they speak.
"""

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian, running_maximum
from . import keeping, trunk

_FACE, _PAST, _BEHIND, _BESIDE = (0.12, 0.1), 0.35, 0.05, 0.2
"""Metres beside the nose, above or below it where a palm hides the face, how far past it towards the other side its forearm
still does, and behind it; and beside it where neither does."""
_COMES = 0.25
"""Seconds over which it comes and goes to the side."""
_NOSE = skeleton.EDGES[2][0]


def passed_by(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 whose arms are turned outwards about the trunk's axis while a hand
    hides the face.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    points = skeleton.to_positions(directions).astype(float)
    free = keeping.free(len(result), given)
    for side, (upper, lower) in enumerate(skeleton.ARMS):
        out, front, down = trunk.axes(directions, points, side)
        palm = points[:, skeleton.EDGES[lower][1]] + trunk.PALM * directions[:, lower]
        aside, ahead, below = trunk.along(palm - points[:, _NOSE], out, front, down)
        hides = (aside > -_PAST) & (aside < _FACE[0]) & (np.abs(below) < _FACE[1]) & (ahead > -_BEHIND)
        if not hides.any():
            continue
        own, before = trunk.along(palm - points[:, skeleton.EDGES[upper][0]], out, front)
        ease = round(_COMES * skeleton.FPS)
        share = free * gaussian(running_maximum(hides.astype(float), ease, ease), 0.5 * ease)
        turn = share * trunk.outwards(own, before, own + np.clip(_BESIDE - aside, 0, _BESIDE + _PAST))
        here = np.flatnonzero(turn)
        for edge in (upper, lower):
            result[here, edge] = trunk.turned(directions[here, edge].astype(float), out[here], front[here], turn[here])
    return result
