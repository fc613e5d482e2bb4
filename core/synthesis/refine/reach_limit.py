"""Limits how far wrists reach ahead, up, across the chest and out to the side or behind: people who talk hardly reach farther,
in no frame of captured talk do hands cross by over 0.05 m, and both are hardly ever spread. Low hands may fold and cross."""

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...motion import skeleton
from ...motion.interpolation import bounded, smoothstep
from ...smoothing import gaussian
from .body import Arm, Body, Correction, dot, outwards

_ACROSS, _ASIDE = 0.1, 0.45
"""Metres of a wrist beyond the body's middle, and away from its own shoulder, which none passes; six and ten more than 98 % of
captured frames, and what viewers send back (:mod:`talk_faults`)."""
_SOFT = 0.15
"""Radians before its limit at which an arm begins to be held back: 0.06 m of a wrist before the body: as those 98 % are."""
_HOLDS, _ENDS, _HANGS = 0.3, 0.45, 0.62
"""Metres below the shoulder down to which that holds, from which on hands may cross (at the hips), and be spread: they hang."""
_BOTH, _BOTH_HANG, _WIDER, _EASE = 0.09, 0.13, 0.06, 0.5
"""Metres that both wrists, raised or hanging, are aside of their shoulders from which on they are led back, and less than which
more are left, in the mean of seconds, so that beats stay: captured talkers are within 0.15 in 98 % of the frames, a style and
a mood that are exaggerated were beyond 0.2 in a third."""
_HIGH, _HIGHER = 0.18, 0.08
"""Metres below its shoulder of a hand from which on it comes down, and less than which it stays above that, in the same mean:
captured hands are within 0.1 in 1 to 2 % of the frames, one woman's in 9 %; takes that chance began so were in a sixth."""
_BRIEF, _LITTLE, _LARGER = int(skeleton.FPS), 0.1, 0.08
"""Frames of a second, metres of a brief rise or drop that is held back, and of what is left; captured: 0.04 to 0.14 in 98 %."""
_BEFORE = 0.1
"""Metres of a hand or its elbow ahead of the shoulder over which the limit across sets in: some go behind the back."""
_AHEAD, _LAST, _SINKS = 0.43, 0.1, 0.1
"""Metres ahead of its shoulder at which a wrist begins to be held back, and less than which more are left: 0.34 to 0.45 in 99 %
of captured frames, but "stop it" needs 0.5. And metres by which a straight arm's elbow counts as lower, so that it sinks."""


def ahead_limit(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Wrists too far ahead, as :func:`reach_limit` may lead them, come back at their height."""
    for arm in body.arms:
        yield _led(arm, -free * bounded(dot(arm.wrist - arm.shoulder, arm.front)[0] - _AHEAD, _LAST), arm.front)


def high_hands(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Hands that are held up come down ("stop it" means it)."""
    for arm in body.arms:
        high = _HIGH - dot(arm.wrist - arm.shoulder, arm.down)[0]
        yield _led(arm, free * bounded(gaussian(np.maximum(high, 0), _EASE * skeleton.FPS), _HIGHER), arm.down)


def hanging_aside(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Arms that hang come in to the body."""
    for arm in body.arms:
        aside, low = dot(arm.wrist - arm.shoulder, arm.out, arm.down)
        wide = gaussian(np.maximum(aside - _BOTH_HANG, 0) * smoothstep(low, _ENDS, _HANGS), _EASE * skeleton.FPS)
        yield arm.roll(np.cross(arm.out, arm.down), free * bounded(wide, _WIDER) / np.maximum(low, _ENDS))


def _led(arm: Arm, far: np.ndarray, way: np.ndarray) -> Correction:
    """The arm whose wrist is led so ``far`` ``(frames,)`` on a ``way`` ``(frames, 3)``; the elbow bends and sinks."""
    here = np.flatnonzero(far)
    reach, elbow = arm.wrist - arm.shoulder + far[:, None] * way, arm.elbow - arm.shoulder + _SINKS * arm.down
    bones = skeleton.LENGTHS[list(arm.edges)].tolist()
    return Correction(arm.edges, np.stack(skeleton.bent_limb(reach[here], elbow[here], *bones, most=1.0), 1), here)


def brief_heights(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Hands that are up, or down, for less than a second go there less far."""
    for arm in body.arms:
        low = dot(arm.wrist - arm.shoulder, arm.down)[0]
        near = sliding_window_view(np.pad(low, _BRIEF - 1, mode="edge"), _BRIEF)
        below, above = (sliding_window_view(ends, _BRIEF) for ends in (near.max(1), near.min(1)))
        back = bounded(below.min(1) - low - _LITTLE, _LARGER) - bounded(low - above.max(1) - _LITTLE, _LARGER)
        yield _led(arm, free * gaussian(back, 1.0), arm.down)


def both_aside(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Arms that are both held out come in about the trunk's axis, as far as the less wide one ("this big" means it)."""
    ways = [dot(arm.wrist - arm.shoulder, arm.out, arm.front, arm.down) for arm in body.arms]
    wide = [aside - _BOTH - (_BOTH_HANG - _BOTH) * smoothstep(low, _ENDS, _HANGS) for aside, _, low in ways]
    back = bounded(gaussian(np.maximum(np.minimum(*wide), 0), _EASE * skeleton.FPS), _WIDER)
    for arm, (aside, ahead, _) in zip(body.arms, ways, strict=True):
        yield arm.swing(free * outwards(aside, ahead, aside - back))


def reach_limit(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Arms that reach too far are turned about the trunk's axis, hands that cross to their sides, far ones to the front."""
    apart = 0.5 * dot(body.arms[1].wrist - body.arms[0].wrist, body.arms[1].out)[0]
    ways = [dot(arm.wrist - arm.shoulder, arm.out, arm.front, arm.down) for arm in body.arms]
    high, raised = ([smoothstep(-low, -end, -begin) for *_, low in ways] for begin, end in ((_HOLDS, _ENDS), (_ENDS, _HANGS)))
    for arm, inner, outer, (aside, ahead, _) in zip(body.arms, high, raised, ways, strict=True):
        before = np.clip(np.maximum(ahead, dot(arm.elbow - arm.shoulder, arm.front)[0]) / _BEFORE, 0, 1)
        reach, turn = np.maximum(np.hypot(aside, ahead), 1e-6), np.arctan2(aside, ahead)
        inward = np.minimum(0.5 * np.linalg.norm(arm.shoulder - arm.opposite, axis=-1) + _ACROSS, apart - aside)
        out, across = (np.arcsin(np.clip(most / reach, -1, 1)) for most in (_ASIDE, inward))
        back = inner * before * bounded(_SOFT - across - turn, _SOFT) - outer * bounded(turn - out + _SOFT, _SOFT)
        yield arm.swing(free * back)
