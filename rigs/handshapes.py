"""Applies handshapes to a rig's fingers: angles to the palm's plane and between links, whatever they are at rest."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..core.motion import handshape, quaternion
from . import fingers
from .palms import Palm
from .skeleton import Bones

MIDDLE_JOINT_SHARE = 0.6
"""Share of the middle joint in the bend of a finger beyond its knuckle."""
SHORT_FINGER_SHARE = 0.75
"""Share of that bend that a finger with a single joint there takes."""
_PLACES = {2: (0.5, -0.5), 3: (0.5, 0.1, -0.5), 4: (0.5, 0.15, -0.17, -0.5), 5: (0.5, 0.25, 0.0, -0.25, -0.5)}
"""Share of the spread for each finger, by the number of fingers."""
_MAX_THUMB = np.radians(45.0)
"""Largest rotation of a thumb's first joint from rest, in radians."""

_Turn = np.ndarray | tuple[np.ndarray, np.ndarray]
"""Rotations (frames, 4) in armature space, or a hinge: its axis (3,) there and angles (frames,) in radians."""


def rotations(bones: Bones, palm: Palm, shape: np.ndarray, strength: float = 1.0) -> dict[str, np.ndarray]:
    """Return rotations ``{bone: (frames, 4)}`` in the bones' rest spaces for the handshapes (frames, 12) in degrees.

    ``strength`` (0..1) scales them. A hand with fewer than four fingers uses those at the nearest places."""
    hand = palm.fingers
    if hand is None or strength <= 0:
        return {}
    turns: dict[int, _Turn] = {}
    count = len(hand.fingers)
    columns = np.linspace(0, 3, count).round().astype(int)
    fan = _fan(bones, palm, hand)
    for place, chain in enumerate(hand.fingers):
        base = handshape.columns(shape, "base")[:, columns[place]]
        rest = handshape.columns(shape, "rest")[:, columns[place]]
        aside = _PLACES[count][place] * (handshape.column(shape, "spread") - fan)
        turns |= _finger(bones, palm, chain, base, rest, aside)
    if len(hand.thumb) >= 2:
        turns |= thumb(bones, palm, hand.thumb, shape)
    result = {}
    for row, turn in turns.items():
        own = bones.rest[row]
        if not bones.inherits[row]:
            continue
        if isinstance(turn, tuple):  # rotate a hinge's axis once instead of in every frame
            axis, angles = turn
            result[bones.names[row]] = quaternion.about(quaternion.rotate(quaternion.conjugate(own), axis), strength * angles)
            continue
        turn = quaternion.power(turn, strength) if strength < 1 else turn
        local = quaternion.multiply(quaternion.conjugate(own), quaternion.multiply(turn, own))
        result[bones.names[row]] = quaternion.continuous(local)
    return result


def read(bones: Bones, palm: Palm, turns: Mapping[int, np.ndarray]) -> np.ndarray:
    """Return the handshapes (frames, 12) of a posed hand, as :func:`rotations` bends it; relaxed where it has no fingers.

    ``turns`` are the rotations (frames, 4) of its bones, by row, from rest and relative to the hand."""
    hand = palm.fingers
    frames = len(next(iter(turns.values()), np.zeros(1)))
    shape = np.tile(handshape.RELAXED.astype(float), (frames, 1))
    if hand is None:
        return shape
    places = np.linspace(0, len(hand.fingers) - 1, len(handshape.FINGERS)).round().astype(int)
    base, rest, ways = zip(*(_bent(bones, palm, chain, turns) for chain in hand.fingers), strict=True)
    shape[:, 0:8:2], shape[:, 1:8:2] = (np.stack(part, -1)[:, places] for part in (base, rest))
    fan = [np.degrees(np.arctan2(way @ palm.thumbwards, way @ palm.knuckles)) for way in (ways[0], ways[-1])]
    shape[:, handshape.COLUMNS.index("spread")] = fan[0] - fan[1]
    if len(hand.thumb) >= 2:
        way = quaternion.rotate(turns[hand.thumb[0]], _link(bones, hand.thumb[0], hand.thumb[1]))
        out, opposed = np.arctan2(way @ palm.thumbwards, way @ palm.knuckles), np.arcsin(np.clip(way @ palm.normal, -1, 1))
        shares = (0.5, 0.5) if len(hand.thumb) > 2 else (0.7,)
        bend = _joint_bend(bones, hand.thumb, turns, _thumb_axis(bones, palm, hand.thumb), shares)
        shape[:, -4:-1] = np.stack([np.degrees(out), np.degrees(opposed), bend], -1)
    return np.clip(shape, handshape.LOW, handshape.HIGH)


def _bent(
    bones: Bones, palm: Palm, chain: Sequence[int], turns: Mapping[int, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the degrees (frames,) by which a finger is bent at its knuckle and beyond it, and its first link (frames, 3)."""
    first = _link(bones, chain[0], chain[1])
    axis = np.cross(first, palm.normal)
    way = quaternion.rotate(turns[chain[0]], first)
    base = np.degrees(np.arcsin(np.clip(way @ palm.normal, -1, 1)))
    shares = (MIDDLE_JOINT_SHARE, 1 - MIDDLE_JOINT_SHARE) if len(chain) > 2 else (SHORT_FINGER_SHARE,)
    return base, _joint_bend(bones, chain, turns, axis / max(np.linalg.norm(axis), 1e-6), shares), way


def _joint_bend(
    bones: Bones, chain: Sequence[int], turns: Mapping[int, np.ndarray], axis: np.ndarray, shares: Sequence[float]
) -> np.ndarray:
    """Return the degrees (frames,) about ``axis`` by which all joints beyond the first bend, each its share."""
    bends, total = fingers.rest_bend(bones, chain, axis)[1:], 0.0
    for above, row, bend in zip(chain, chain[1:3], bends, strict=False):
        own = quaternion.multiply(quaternion.conjugate(turns[above]), turns[row])
        total = total + (np.degrees(2 * np.arctan2(own[..., 1:] @ axis, own[..., 0])) + 180) % 360 - 180 + bend
    return np.asarray(total / sum(shares))


def _finger(
    bones: Bones, palm: Palm, chain: Sequence[int], base: np.ndarray, rest: np.ndarray, aside: np.ndarray
) -> dict[int, _Turn]:
    """Return the turns of a finger's joints, up to three, by row; ``base``, ``rest`` and ``aside`` (frames,) are degrees."""
    first = _link(bones, chain[0], chain[1])
    axis = np.cross(first, palm.normal)
    axis = axis / max(np.linalg.norm(axis), 1e-6)
    bends = fingers.rest_bend(bones, chain, axis)[1:]
    bent = np.degrees(np.arcsin(np.clip(first @ palm.normal, -1, 1)))
    sideways = quaternion.about(palm.normal, np.radians(aside) * np.sign(np.cross(palm.normal, first) @ palm.thumbwards or 1))
    bend = quaternion.about(np.broadcast_to(axis, (len(base), 3)), np.radians(base - bent))
    turns: dict[int, _Turn] = {chain[0]: quaternion.multiply(sideways, bend)}
    shares = (MIDDLE_JOINT_SHARE, 1 - MIDDLE_JOINT_SHARE) if len(chain) > 2 else (SHORT_FINGER_SHARE,)
    for row, share, bend in zip(chain[1:3], shares, bends, strict=True):
        turns[row] = axis, np.radians(share * rest - bend)
    return turns


def thumb(bones: Bones, palm: Palm, chain: Sequence[int], shape: np.ndarray) -> dict[int, _Turn]:
    """Return the turns of a thumb's joints, up to three, by row, for handshapes (frames, 12)."""
    first = _link(bones, chain[0], chain[1])
    out, opposed = (np.radians(handshape.column(shape, name)) for name in ("thumb_out", "thumb_opposition"))
    flat = np.stack([np.cos(opposed) * np.cos(out), np.sin(opposed), np.cos(opposed) * np.sin(out)], -1)
    swing = quaternion.swing(np.broadcast_to(first, flat.shape), flat @ palm.frame.T)
    angle = 2 * np.arccos(np.clip(np.abs(swing[:, 0]), 0, 1))
    turns: dict[int, _Turn] = {chain[0]: quaternion.power(swing, np.minimum(1.0, _MAX_THUMB / np.maximum(angle, 1e-6)))}
    axis = _thumb_axis(bones, palm, chain)
    bends = fingers.rest_bend(bones, chain, axis)[1:]
    shares = (0.5, 0.5) if len(chain) > 2 else (0.7,)
    for row, share, bend in zip(chain[1:3], shares, bends, strict=True):
        turns[row] = axis, np.radians(share * handshape.column(shape, "thumb_bend") - bend)
    return turns


def _thumb_axis(bones: Bones, palm: Palm, chain: Sequence[int]) -> np.ndarray:
    """Return the unit axis (3,) about which a thumb bends."""
    axis = np.cross(_link(bones, chain[0], chain[:3][-1]), 0.6 * palm.normal - 0.8 * palm.thumbwards)
    return axis / max(np.linalg.norm(axis), 1e-6)


def _fan(bones: Bones, palm: Palm, hand: fingers.Hand) -> float:
    """Return the angle in degrees between the first and the last finger at rest, in the palm's plane."""
    ways = [_link(bones, chain[0], chain[1]) for chain in (hand.fingers[0], hand.fingers[-1])]
    first, last = (np.degrees(np.arctan2(way @ palm.thumbwards, way @ palm.knuckles)) for way in ways)
    return float(first - last)


def _link(bones: Bones, start: int, end: int) -> np.ndarray:
    """Return the unit vector (3,) from head to head."""
    return fingers.unit(bones.heads[end] - bones.heads[start])
