"""Hands that have stayed past the body's middle for long go back to their own side: people cross before themselves and come
back, and hardly ever lay a forearm before the belly while they speak.

Where both are past it, which is a hug, they do so at once. Hands above the shoulders and hanging ones cross as they like.
"""

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian, running_maximum
from . import keeping, trunk

_PAST, _HUG = -0.03, 0.0
"""Metres beyond the middle from which on one palm counts as past it, and two do."""
_HOME, _SOON = -0.08, 0.03
"""Metres beyond the middle where a palm is led to, and over how many more that sets in."""
_HIGH, _LOW, _OVER = 0.08, -0.6, 0.06
"""Metres above the shoulders between which hands linger, and over how many that fades."""
_LONG, _GAP, _TAKES, _BRIEF = 0.8, 0.2, 0.4, 0.1
"""Seconds that a hand may stay, for which it may be away meanwhile, in which it goes and is back, and the least for either,
as the width of a Gaussian."""


def led_back(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 whose hands are on the other side for a moment only.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    points = skeleton.to_positions(directions).astype(float)
    free = keeping.free(len(result), given)
    found = [_palm(directions, points, side) for side in range(len(skeleton.ARMS))]
    hugs = np.all([(past > _HUG) & (between > 0) for past, between, *_ in found], axis=0)
    for arm, (past, between, place, ways) in zip(skeleton.ARMS, found, strict=True):
        stays = _stays((past > _PAST) & (between > 0), hugs)
        beyond = np.maximum(past - _HOME, 0)
        back = gaussian(beyond**2 / (beyond + _SOON) * stays * between, _BRIEF * skeleton.FPS) * free
        here = np.flatnonzero(back)
        out, front = (way[here] for way in ways)
        aside, ahead = (part[here] for part in place)
        turn = trunk.outwards(aside, ahead, aside + back[here])
        for edge in arm:
            result[here, edge] = trunk.turned(directions[here, edge].astype(float), out, front, turn)
    return result


def _palm(directions: np.ndarray, points: np.ndarray, side: int) -> tuple:
    """Metres of a palm beyond the body's middle, how much it is at heights where hands linger, and how far it is aside and
    ahead of its shoulder, each ``(frames,)``; with the axes of these two.
    """
    out, front, down = trunk.axes(directions, points, side)
    upper, lower = skeleton.ARMS[side]
    shoulder, other = (points[:, skeleton.EDGES[arm[0]][0]] for arm in (skeleton.ARMS[side], skeleton.ARMS[1 - side]))
    palm = points[:, skeleton.EDGES[lower][1]] + trunk.PALM * directions[:, lower]
    aside, ahead = trunk.along(palm - shoulder, out, front)
    inner, below = trunk.along(palm - 0.5 * (shoulder + other), -out, down)
    between = np.clip((-_LOW - below) / _OVER, 0, 1) * np.clip((_HIGH + below) / _OVER, 0, 1)
    return inner, between, (aside, ahead), (out, front)


def _stays(past: np.ndarray, hugs: np.ndarray) -> np.ndarray:
    """How much ``(frames,)`` a hand has stayed too long: of stays all but their beginning, of hugs all."""
    gap, long, takes = (round(seconds * skeleton.FPS) for seconds in (_GAP, _LONG, _TAKES))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], past, [0]]).astype(int))).reshape(-1, 2).tolist()
    spans: list[list[int]] = []
    for start, stop in edges:
        if spans and start - spans[-1][1] <= gap:
            spans[-1][1] = stop
        else:
            spans.append([start, stop])
    held = running_maximum(hugs.astype(float), takes // 2, takes // 2)
    for start, stop in spans:
        held[start + long : stop + min(takes // 2, max(stop - start - long, 0))] = 1
    return gaussian(held, 0.3 * takes)
