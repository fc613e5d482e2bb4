"""What is meant laid over a performance: arms, head and shoulders go to the gesture in time for its word, and back."""

from collections.abc import Sequence

import numpy as np

from ..motion import rest, skeleton
from ..motion.curves import ramp
from ..motion.hands import Hands
from .choosing import Shown

_HEAD, _TRUNK = (1, 2), (3, 6)
_MIRROR = np.array([-1.0, 1.0, 1.0])
_SHAKES, _SHAKEN = 2.0, 1.1
"""How often a head that says no goes to and fro, and the seconds that it takes."""
_TIRED = 0.08
"""Share of the way back that a held arm sinks."""
_AROUND = 0.6
"""Seconds around a gesture in which the arm that does more is looked for."""


def sides(directions: np.ndarray, shown: Sequence[Shown]) -> list[tuple[bool, bool]]:
    """Whether the left and the right arm show each gesture: by ``side``, or the arm that the performance raises more."""
    time = np.arange(len(directions)) / skeleton.FPS
    lift = np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))
    result = []
    for one in shown:
        side = one.side
        if one.gesture.arms == "both" and not side:
            result.append((True, True))
            continue
        if not side:
            near = (time > one.begin - _AROUND) & (time < one.end + _AROUND)
            left, right = (lift[near][:, list(arm)].sum() for arm in skeleton.ARMS)
            side = -1.0 if left > right else 1.0
        result.append((side < 0, side > 0))
    return result


def weights(one: Shown, time: np.ndarray) -> np.ndarray:
    """How much of a gesture is there ``(frames,)``, 0..1."""
    return ramp(time, one.begin, one.ready) * (1 - ramp(time, one.until, one.end))


def show(directions: np.ndarray, shown: Sequence[Shown], which: Sequence[tuple[bool, bool]]) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 at 15 fps with every gesture; outside of them all stays as it was to the bit.

    ``which`` arms show each of them: :func:`sides` of the same directions.
    """
    result, time = np.array(directions, np.float32), np.arange(len(directions)) / skeleton.FPS
    for one, arms in zip(shown, which, strict=True):
        here = slice(*np.searchsorted(time, [one.begin, max(one.end, one.lands + _SHAKEN)]))
        if here.start == here.stop:
            continue
        part, now = result[here].astype(float), time[here]
        weight = weights(one, now)
        acted = one.gesture.acted
        if acted is not None:
            acted.play(part, now - one.lands, weight, arms)
        for arm, (edges, mirror) in enumerate(zip(skeleton.ARMS, (np.ones(3), _MIRROR), strict=True)):
            if arms[arm] and acted is None:
                part[:, edges] = rest.slerp(part[:, edges], _arm(one, now) * mirror, one.size * weight[:, None])
        _bear(part, one, arms, now, weight)
        result[here] = skeleton.normalize(part)
    return result


def _arm(one: Shown, time: np.ndarray) -> np.ndarray:
    """Upper arm and forearm ``(frames, 2, 3)`` of the left arm from ready to the stroke, and sinking a little while held."""
    swing = ramp(time, one.ready - 0.1, one.lands) - _TIRED * ramp(time, one.lands, max(one.until, one.lands + 0.3))
    poses = rest.slerp(one.gesture.ready, one.gesture.stroke, swing[:, None])
    return turned(poses, 1, np.full(len(time), one.across)) if one.across else poses


def _bear(part: np.ndarray, one: Shown, arms: tuple[bool, bool], time: np.ndarray, weight: np.ndarray) -> None:
    """Head and shoulders of a gesture, in place."""
    gesture, side = one.gesture, float(arms[1]) - float(arms[0])
    landed = weight * ramp(time, one.ready - 0.15, one.lands + 0.1)
    for edge, sign in zip(_TRUNK, (-1, 1), strict=True):
        part[:, edge] = turned(part[:, edge], 2, -sign * gesture.shoulders * landed)
    through = np.clip((time - one.lands + 0.3) / _SHAKEN, 0, 1)
    yaw = gesture.shake * np.sin(2 * np.pi * _SHAKES * through) * np.sin(np.pi * through) + gesture.turn * side * landed
    roll = (side or 1.0) * gesture.tilt * landed
    for edge in _HEAD:
        part[:, edge] = turned(turned(part[:, edge], 2, roll), 1, yaw)


def hands(performed: Hands, shown: Sequence[Shown], which: Sequence[tuple[bool, bool]]) -> Hands:
    """Hands of a performance that show what each gesture means: where the palm looks, where it points, and its fingers.

    ``which`` as for :func:`show`.
    """
    knuckles, palms, shape = performed.knuckles.copy(), performed.palms.copy(), performed.shape.copy()
    time = np.arange(len(performed)) / skeleton.FPS
    for one, arms in zip(shown, which, strict=True):
        weight = weights(one, time)[:, None]
        own = one.gesture.acted and one.gesture.acted.hands(time - one.lands, arms)
        for arm in (arm for arm in (0, 1) if own and arms[arm]):
            for parts, played in ((knuckles, own.knuckles), (palms, own.palms)):
                parts[:, arm] = rest.slerp(parts[:, arm], played[:, arm], weight[:, 0])
            shape[:, arm] += weight * (own.shape[:, arm] - shape[:, arm])
        weight = weight * ramp(time, one.ready - 0.2, one.lands)[:, None]
        for arm, mirror in enumerate((np.ones(3), _MIRROR)):
            for parts, wanted in ((knuckles, one.gesture.knuckles), (palms, one.gesture.palm)):
                if arms[arm] and wanted is not None:
                    parts[:, arm] = rest.slerp(parts[:, arm], wanted * mirror, weight[:, 0])
            if arms[arm] and one.gesture.shape is not None:
                shape[:, arm] += weight * (one.gesture.shape - shape[:, arm])
    return Hands.of(knuckles, palms, shape)


def turned(vectors: np.ndarray, axis: int, degrees: np.ndarray) -> np.ndarray:
    """Vectors ``(frames, ..., 3)`` turned about a coordinate axis by angles ``(frames,)``."""
    angle = np.radians(degrees).reshape(-1, *[1] * (vectors.ndim - 2))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    result = vectors.copy()
    result[..., one] = np.cos(angle) * vectors[..., one] - np.sin(angle) * vectors[..., two]
    result[..., two] = np.sin(angle) * vectors[..., one] + np.cos(angle) * vectors[..., two]
    return result
