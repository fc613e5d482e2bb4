"""Lowers elbows that are held up like wings over a low hand; people's elbows are so high where the hand is higher still."""

from collections.abc import Iterator

import numpy as np

from ...motion import skeleton
from ...motion.interpolation import bounded
from ...smoothing import gaussian, running_maximum
from .body import Body, Correction, dot

_HIGH, _SOFT = 0.22, 0.06
"""Metres below the shoulder above which an elbow is too high, and over which that sets in: 0.16 m are left, which is the 0.1
that viewers send back (:mod:`talk_faults`) on a character whose upper arm is 0.23 m long and not 0.36."""
_HAND_BELOW, _FADE = -0.04, 0.1
"""Metres of the hand below the elbow from which on the rule holds wholly, and over which it sets in."""
_EASE = 0.13
"""Standard deviation in seconds by which the rule comes and goes."""
_MIN_LEVER, _INNER = 0.02, 2.1
"""Metres from the line shoulder to wrist at which an elbow can be turned at all; radians from the lowest place up to which it
sinks on the body's side of that line, where elbows hardly are: from the highest one it always sinks outside."""


def elbow_wings(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """The arm is turned about the line from shoulder to wrist, so that the hand stays where it was."""
    for arm, outer in zip(body.arms, (1, -1), strict=True):
        elbow = arm.elbow - arm.shoulder
        below, hangs = (dot(way, arm.down)[0] for way in (elbow, arm.wrist - arm.elbow))
        high = np.maximum(_HIGH - below, 0) * np.clip((hangs - _HAND_BELOW) / _FADE + 1, 0, 1)
        if not high.any():
            continue
        axis = skeleton.normalize(arm.wrist - arm.shoulder)
        held = round(_EASE * skeleton.FPS)
        wanted = gaussian(running_maximum(bounded(high, _SOFT), held, held), 0.5 * held)
        angle = outer * gaussian(_lowering(elbow, axis, arm.down, outer, wanted), _EASE * skeleton.FPS)
        yield arm.roll(axis, angle * free)


def _lowering(elbow: np.ndarray, axis: np.ndarray, down: np.ndarray, outer: int, wanted: np.ndarray) -> np.ndarray:
    """Radians ``(frames,)`` about ``outer`` times an ``axis``, a side of 1 or -1, by which elbows, seen from their shoulders,
    sink by the ``wanted`` metres, or as far as they can."""
    aside, low = (vectors - dot(vectors, axis)[0][:, None] * axis for vectors in (elbow, down))
    x, y = dot(aside, low, outer * np.cross(axis, low))
    now, steep = (np.arctan2(y, x) + _INNER) % (2 * np.pi) - _INNER, np.linalg.norm(low, axis=-1)
    there = np.arccos(np.clip(np.cos(now) + wanted / np.maximum(np.linalg.norm(aside, axis=-1) * steep, _MIN_LEVER), -1, 1))
    return np.where(np.hypot(x, y) > _MIN_LEVER * steep, np.sign(now) * there - now, 0.0)
