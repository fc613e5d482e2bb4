"""Blends semantic gestures into a motion: arms, head and shoulders reach the gesture in time for its word and return."""

from collections.abc import Sequence

import numpy as np

from ..motion import rest, skeleton
from ..motion.hands import Hands
from ..motion.interpolation import ramp
from .gesture_selection import ScheduledGesture

_TRUNK = 3, 6
_MIRROR = np.array([-1.0, 1.0, 1.0])
_SHAKES, _SHAKE_SECONDS = 2.0, 1.1
"""Number of cycles of a head shake, and its duration."""
_ROLL = -0.35
"""Degrees by which a head that shakes tilts, for each that it turns: of a head that is upright a turn alone shows little."""
_SINK = 0.08
"""Share of the stroke by which an arm sinks during the hold."""
_MARGIN_SECONDS = 0.6
"""Added before and after a gesture when determining which arm moves more."""


def arms_of_gestures(directions: np.ndarray, shown: Sequence[ScheduledGesture]) -> list[tuple[bool, bool]]:
    """Return whether the left and the right arm show each gesture: by its ``side``, else the arm that is raised more.

    ``directions`` are ``(frames, 9, 3)`` at 15 fps."""
    time = np.arange(len(directions)) / skeleton.FPS
    lift = np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))
    result = []
    for item in shown:
        side = item.side
        differ = item.gesture.other is not None or item.gesture.other_shape is not None  # the arms show two things
        if item.gesture.arms == "both" and (not side or differ):
            result.append((True, True))
            continue
        if not side:
            near = (time > item.begin - _MARGIN_SECONDS) & (time < item.end + _MARGIN_SECONDS)
            left, right = (lift[near][:, list(arm)].sum() for arm in skeleton.ARMS)
            side = -1.0 if left > right else 1.0
        result.append((side < 0, side > 0))
    return result


def blend_weight(item: ScheduledGesture, time: np.ndarray) -> np.ndarray:
    """Return the blend weight of a gesture, ``(frames,)`` 0..1, at ``time`` ``(frames,)`` in seconds."""
    return ramp(time, item.begin, item.ready) * (1 - ramp(time, item.until, item.end))


def blend_gestures(directions: np.ndarray, shown: Sequence[ScheduledGesture], which: Sequence[tuple[bool, bool]]) -> np.ndarray:
    """Add the gestures to directions ``(frames, 9, 3)`` at 15 fps; return them as float32, bit-equal outside of gestures.

    ``which`` is the result of :func:`arms_of_gestures` for the same directions."""
    result, time = np.array(directions, np.float32), np.arange(len(directions)) / skeleton.FPS
    for item, arms in zip(shown, which, strict=True):
        here = slice(*np.searchsorted(time, [item.begin, max(item.end, item.lands + _SHAKE_SECONDS)]))
        if here.start == here.stop:
            continue
        part, now = result[here].astype(float), time[here]
        weight = blend_weight(item, now)
        acted = item.gesture.acted
        if acted is not None:
            acted.blend_into(part, now - item.lands, weight, arms)
        for arm, (edges, mirror) in enumerate(zip(skeleton.ARMS, (np.ones(3), _MIRROR), strict=True)):
            if arms[arm] and acted is None:
                part[:, edges] = rest.slerp(part[:, edges], _arm(item, now, arm) * mirror, item.size * weight[:, None])
        _move_body(part, item, arms, now, weight)
        result[here] = skeleton.normalize(part)
    return result


def _leading(item: ScheduledGesture) -> int:
    return 0 if item.side < 0 else 1


def _arm(item: ScheduledGesture, time: np.ndarray, arm: int) -> np.ndarray:
    """Return upper arm and forearm ``(frames, 2, 3)`` for ``arm``, mirrored to the left one: its path, a sinking hold."""
    gesture = item.gesture
    path = gesture.path if gesture.other is None or arm == _leading(item) else gesture.other
    swing = ramp(time, item.ready - 0.1, item.lands) - _SINK * ramp(time, item.lands, max(item.until, item.lands + 0.3))
    poses = _along(path, swing)
    return skeleton.rotate_about_axis(poses, 1, np.full(len(time), item.across)) if item.across else poses


def _along(path: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return unit vectors ``(frames, ...)`` at shares ``(frames,)`` 0..1 of the way through ``path`` ``(n, ..., 3)``."""
    if len(path) == 1:
        return np.repeat(path, len(share), 0)
    place = share * (len(path) - 1)
    low = np.clip(place.astype(int), 0, len(path) - 2)
    return rest.slerp(path[low], path[low + 1], (place - low).reshape(-1, *[1] * (path.ndim - 2)))


def _move_body(part: np.ndarray, item: ScheduledGesture, arms: tuple[bool, bool], time: np.ndarray, weight: np.ndarray) -> None:
    """Add the head and shoulder movements of a gesture in place."""
    gesture, side = item.gesture, float(arms[1]) - float(arms[0])
    landed = weight * ramp(time, item.ready - 0.15, item.lands + 0.1)
    for edge, sign in zip(_TRUNK, (-1, 1), strict=True):
        part[:, edge] = skeleton.rotate_about_axis(part[:, edge], 2, -sign * gesture.shoulders * landed)
    phase = np.clip((time - item.lands + 0.3) / _SHAKE_SECONDS, 0, 1)
    shaken = gesture.shake * np.sin(2 * np.pi * _SHAKES * phase) * np.sin(np.pi * phase)
    yaw = shaken + gesture.turn * side * landed
    roll = (side or 1.0) * gesture.tilt * landed + _ROLL * shaken
    for edge in skeleton.HEAD:
        part[:, edge] = skeleton.rotate_about_axis(skeleton.rotate_about_axis(part[:, edge], 2, roll), 1, yaw)


def blend_hands(performed: Hands, shown: Sequence[ScheduledGesture], which: Sequence[tuple[bool, bool]]) -> Hands:
    """Blend the palm, direction and handshape of every gesture into the hands of a motion at 15 fps.

    ``which`` is the same as for :func:`blend_gestures`."""
    knuckles, palms, shape = performed.knuckles.copy(), performed.palms.copy(), performed.shape.copy()
    time = np.arange(len(performed)) / skeleton.FPS
    for item, arms in zip(shown, which, strict=True):
        gesture, weight = item.gesture, blend_weight(item, time)[:, None]
        clip = gesture.acted.hands(time - item.lands, arms) if gesture.acted is not None else None
        for arm in (0, 1):
            if clip and arms[arm]:
                for parts, played in ((knuckles, clip.knuckles), (palms, clip.palms)):
                    parts[:, arm] = rest.slerp(parts[:, arm], played[:, arm], weight[:, 0])
                shape[:, arm] += weight * (clip.shape[:, arm] - shape[:, arm])
        share = ramp(time, item.ready - 0.1, item.lands)
        shown_from = weight if gesture.palm is not None and len(gesture.palm) > 1 else weight * ramp(
            time, item.ready - 0.2, item.lands
        )[:, None]
        for arm, mirror in enumerate((np.ones(3), _MIRROR)):
            if not arms[arm]:
                continue
            if gesture.knuckles is not None:
                knuckles[:, arm] = rest.slerp(knuckles[:, arm], gesture.knuckles * mirror, shown_from[:, 0])
            if gesture.palm is not None:
                palms[:, arm] = rest.slerp(palms[:, arm], _along(gesture.palm, share) * mirror, shown_from[:, 0])
            follows = gesture.other_shape is not None and arm != _leading(item)
            fingers = gesture.other_shape if follows else gesture.shape
            if fingers is not None:
                way = np.linspace(0, 1, len(fingers)) if len(fingers) > 1 else np.zeros(1)
                wanted = np.stack([np.interp(share, way, column) for column in fingers.T], -1)
                shape[:, arm] += (weight if len(fingers) > 1 else shown_from) * (wanted - shape[:, arm])
    return Hands.of(knuckles, palms, shape)
