"""Limits how long hands stay past the body's middle: people cross before themselves and come back, and hardly ever lay a
forearm before the belly while they speak.

Both hands past the middle, which is a hug, are led back at once. Hands above the shoulders and hanging ones may cross.
"""

from collections.abc import Iterator

import numpy as np

from ...motion import skeleton
from ...motion.interpolation import true_runs
from ...smoothing import gaussian, running_maximum
from .body import Arm, Body, Correction, Take, dot, knee, outwards

_PAST, _HUG = -0.03, 0.0
"""Metres beyond the middle from which on one palm counts as past it, and two do."""
_HOME, _SOFT = -0.08, 0.03
"""Metres beyond the middle to which a palm is led, and over which that sets in."""
_HIGH, _LOW, _FADE = 0.08, -0.6, 0.06
"""Metres above the shoulders between which the rule holds, and over which it fades."""
_DWELL, _GAP, _WAY, _EASE = 0.8, 0.2, 0.4, 0.1
"""Seconds that a hand may stay, for which it may be away meanwhile, in which it goes back, and the least for that as a
standard deviation."""


def midline_dwell(body: Body, take: Take) -> Iterator[Correction]:
    """Arms whose hand stayed too long are turned outwards about the trunk's axis."""
    palms = [_palm(arm) for arm in body.arms]
    hugs = np.all([(beyond > _HUG) & (between > 0) for beyond, between in palms], axis=0)
    for arm, (beyond, between) in zip(body.arms, palms, strict=True):
        stays = _too_long((beyond > _PAST) & (between > 0), hugs)
        back = gaussian(knee(beyond - _HOME, _SOFT) * stays * between, _EASE * skeleton.FPS) * take.free(len(stays))
        aside, ahead = dot(arm.palm - arm.shoulder, arm.out, arm.front)
        yield arm.swing(np.where(back > 0, outwards(aside, ahead, aside + back), 0.0))


def _palm(arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Metres of a palm beyond the body's middle ``(frames,)``, and how far it is at a height where the rule holds, 0..1."""
    beyond, below = dot(arm.palm - 0.5 * (arm.shoulder + arm.opposite), -arm.out, arm.down)
    return beyond, np.clip((-_LOW - below) / _FADE, 0, 1) * np.clip((_HIGH + below) / _FADE, 0, 1)


def _too_long(past: np.ndarray, hugs: np.ndarray) -> np.ndarray:
    """How far ``(frames,)`` a hand has stayed too long, 0..1: of stays all but their beginning, of hugs all."""
    gap, dwell, way = (round(seconds * skeleton.FPS) for seconds in (_GAP, _DWELL, _WAY))
    stays: list[list[int]] = []
    for start, stop in true_runs(past).tolist():
        if stays and start - stays[-1][1] <= gap:
            stays[-1][1] = stop
        else:
            stays.append([start, stop])
    late = running_maximum(hugs.astype(float), way // 2, way // 2)
    for start, stop in stays:
        late[start + dwell : stop + min(way // 2, max(stop - start - dwell, 0))] = 1
    return gaussian(late, 0.3 * way)
