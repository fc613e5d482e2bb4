"""Small pictures of gestures: a figure seen from the front, where its hands go, and its fingers as the stroke ends."""

from typing import Any

import numpy as np

from ..motion import handshape, skeleton
from ..motion.motion import Motion
from ..motion.rest import REST
from .gesture import Gesture

SIZE = 64
"""Width and height of a picture in pixels."""
_METRE, _MIDDLE = 46.0, (30.0, 21.0)
"""Pixels of a metre, and where the spine joint lies, in pixels from the left and from the bottom."""
_TURN, _DOWN = np.radians(28.0), np.radians(5.0)
"""Angles from which the figure is seen: a little from its right, and from above, so that what goes forward shows."""
_BODY, _ARM, _WAY = (0.6, 0.6, 0.62, 1.0), (1.0, 0.66, 0.25, 1.0), (0.35, 0.7, 1.0, 0.9)
"""Colours, RGBA 0..1: the figure, arms that show something, and the way of a hand."""
_BENT = 100.0
"""Degrees by which the joints of a finger are bent in all that is not stretched."""
_BEFORE, _LEFTWARDS = 0.6, np.array([-1.0, 1.0, 1.0])
"""Seconds before a moment of a motion of which ways are drawn, and the mirror of a right arm."""
_FINGER, _THUMB = 0.2, 0.14
"""Metres of fingers, larger than they are so that they can be counted."""


def draw(gesture: Gesture, size: int = SIZE) -> np.ndarray:
    """Return the picture of a gesture, RGBA 0..1 ``(size, size, 4)``, its first row at the bottom."""
    both = gesture.arms != "one" or gesture.other is not None
    leads = 0 if gesture.side < 0 else 1
    shown = (0, 1) if both else (leads,)
    pose, ways = REST.astype(float), {}
    for arm in shown:
        path = gesture.path if gesture.other is None or arm == leads else gesture.other
        path = path * (np.array([-1.0, 1, 1]) if arm else 1.0)
        if gesture.arms == "alternate" and arm != leads:
            path = path[[0, 0]]
        steps = np.repeat(pose[None], len(path), 0)
        steps[:, skeleton.ARMS[arm]] = path
        ways[arm] = skeleton.to_positions(steps)[:, skeleton.EDGES[skeleton.ARMS[arm][1]][1]]
        pose = steps[-1]
    joints = skeleton.to_positions(pose)
    picture = np.zeros((size, size, 4))
    for edge, (parent, child) in enumerate(skeleton.EDGES):
        if edge not in (1, 2):
            _line(picture, joints[[parent, child]], 2.0 if edge in skeleton.ARM_EDGES else 2.4, _BODY)
    _line(picture, joints[[0, 0]] + [[0, 0, 0], [0, 0.25, 0]], 3.4, _BODY)  # the trunk below the spine joint
    _line(picture, joints[[1, 1]] + [[0, -0.24, 0.03]], 5.4, _BODY)  # the head
    for arm in shown:
        _line(picture, ways[arm], 0.9, _WAY)
        _line(picture, joints[[skeleton.EDGES[edge][0] for edge in skeleton.ARMS[arm]]], 2.0, _ARM)
        _line(picture, joints[[skeleton.EDGES[skeleton.ARMS[arm][1]][0], skeleton.EDGES[skeleton.ARMS[arm][1]][1]]], 2.0, _ARM)
        _hand(picture, joints, pose, gesture, arm, leads)
    return picture.clip(0, 1)


def gesture_of(motion: Motion, at: float, hand: str) -> Gesture:
    """Return what the arms and hands of a motion do until ``at`` seconds; ``hand`` is left, right or both."""
    last = min(max(round(at * motion.fps), 1), len(motion.directions) - 1)
    arms = motion.directions[max(last - round(_BEFORE * motion.fps), 0) : last + 1][:, np.array(skeleton.ARMS)].astype(float)
    ways = arms[:, 0], arms[:, 1] * _LEFTWARDS
    leads = 0 if hand == "left" else 1
    about: dict[str, Any] = {"other": ways[1 - leads]} if hand == "both" else {}
    if motion.hands is not None:
        mirror = _LEFTWARDS if leads else np.ones(3)
        about["palm"] = motion.hands.palms[last, leads][None] * mirror
        about["knuckles"] = motion.hands.knuckles[last, leads] * mirror
        about["shape"] = motion.hands.shape[last, leads][None]
        about |= {"other_shape": motion.hands.shape[last, 1 - leads][None]} if hand == "both" else {}
    return Gesture("", "both" if hand == "both" else "one", ways[leads], side=1.0 if leads else -1.0, **about)


def _hand(picture: np.ndarray, joints: np.ndarray, pose: np.ndarray, gesture: Gesture, arm: int, leads: int) -> None:
    """Draw the stretched fingers of a hand, spread in the plane of its palm."""
    mirror = np.array([-1.0, 1, 1]) if arm else np.ones(3)
    fore = skeleton.ARMS[arm][1]
    wrist, along = joints[skeleton.EDGES[fore][1]], pose[fore]
    along = along if gesture.knuckles is None else gesture.knuckles * mirror
    palm = np.array([0.0, 1, 0]) if gesture.palm is None else gesture.palm[-1] * mirror
    side = skeleton.normalize(np.cross(palm, along)) * (1 if arm else -1)  # towards the thumb
    fingers = gesture.other_shape if gesture.other_shape is not None and arm != leads else gesture.shape
    shape = (handshape.RELAXED if fingers is None else fingers[-1]).astype(float)
    _line(picture, np.stack([wrist, wrist + 0.04 * along]), 2.6, _ARM)
    bent = handshape.columns(shape, "rest") + handshape.columns(shape, "base")
    for number, angle in enumerate(bent):
        if angle < _BENT:
            way = along + (0.3 - 0.2 * number) * side
            _line(picture, np.stack([wrist, wrist + _FINGER * skeleton.normalize(way)]), 0.8, _ARM)
    if handshape.column(shape, "thumb_bend") < _BENT / 2 and handshape.column(shape, "thumb_out") > 20:
        _line(picture, np.stack([wrist, wrist + _THUMB * skeleton.normalize(along + 1.2 * side)]), 0.9, _ARM)


def _line(picture: np.ndarray, points: np.ndarray, radius: float, colour: tuple[float, ...]) -> None:
    """Draw a line through points ``(n, 3)`` in metres, ``radius`` pixels thick, with smooth edges, over the picture."""
    (x, y, z), size = points.T, len(picture)
    across, deep = -x * np.cos(_TURN) + z * np.sin(_TURN), z * np.cos(_TURN) + x * np.sin(_TURN)
    flat = np.stack([_MIDDLE[0] + _METRE * across, _MIDDLE[1] - _METRE * (y * np.cos(_DOWN) + deep * np.sin(_DOWN))], -1)
    flat, radius = flat * size / SIZE, radius * size / SIZE
    low = np.floor(flat.min(0) - radius - 1).clip(0, size).astype(int)
    high = np.ceil(flat.max(0) + radius + 1).clip(0, size).astype(int)
    part = picture[low[1] : high[1], low[0] : high[0]]
    pixels = np.moveaxis(np.mgrid[low[0] : high[0], low[1] : high[1]], 0, -1).swapaxes(0, 1) + 0.5
    ways = np.diff(flat, axis=0)
    offsets = pixels[:, :, None] - flat[:-1]
    share = ((offsets * ways).sum(-1) / np.maximum((ways**2).sum(-1), 1e-9)).clip(0, 1)
    apart = np.linalg.norm(offsets - share[..., None] * ways, axis=-1).min(-1)
    cover = (colour[3] * (radius + 0.5 - apart).clip(0, 1))[..., None]
    alpha = cover + (1 - cover) * part[..., 3:]
    part[..., :3] = (cover * np.array(colour[:3]) + (1 - cover) * part[..., 3:] * part[..., :3]) / np.maximum(alpha, 1e-9)
    part[..., 3:] = alpha
