"""Applies handshapes to a rig's fingers: angles to the palm's plane and between links, whatever they are at rest."""

from collections.abc import Sequence

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
        turns |= _thumb(bones, palm, hand.thumb, shape)
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
    turns: dict[int, _Turn] = {chain[0]: quaternion.multiply(sideways, _bend(axis, base - bent))}
    shares = (MIDDLE_JOINT_SHARE, 1 - MIDDLE_JOINT_SHARE) if len(chain) > 2 else (SHORT_FINGER_SHARE,)
    for row, share, bend in zip(chain[1:3], shares, bends, strict=True):
        turns[row] = axis, np.radians(share * rest - bend)
    return turns


def _thumb(bones: Bones, palm: Palm, chain: Sequence[int], shape: np.ndarray) -> dict[int, _Turn]:
    """Return the turns of a thumb's joints, up to three, by row, for handshapes (frames, 12)."""
    first = _link(bones, chain[0], chain[1])
    out, opposed = (np.radians(handshape.column(shape, name)) for name in ("thumb_out", "thumb_opposition"))
    flat = np.stack([np.cos(opposed) * np.cos(out), np.sin(opposed), np.cos(opposed) * np.sin(out)], -1)
    swing = quaternion.swing(np.broadcast_to(first, flat.shape), flat @ palm.frame.T)
    angle = 2 * np.arccos(np.clip(np.abs(swing[:, 0]), 0, 1))
    turns: dict[int, _Turn] = {chain[0]: quaternion.power(swing, np.minimum(1.0, _MAX_THUMB / np.maximum(angle, 1e-6)))}
    along = _link(bones, chain[0], chain[:3][-1])
    axis = np.cross(along, 0.6 * palm.normal - 0.8 * palm.thumbwards)
    axis = axis / max(np.linalg.norm(axis), 1e-6)
    bends = fingers.rest_bend(bones, chain, axis)[1:]
    shares = (0.5, 0.5) if len(chain) > 2 else (0.7,)
    for row, share, bend in zip(chain[1:3], shares, bends, strict=True):
        turns[row] = axis, np.radians(share * handshape.column(shape, "thumb_bend") - bend)
    return turns


def _fan(bones: Bones, palm: Palm, hand: fingers.Hand) -> float:
    """Return the angle in degrees between the first and the last finger at rest, in the palm's plane."""
    ways = [_link(bones, chain[0], chain[1]) for chain in (hand.fingers[0], hand.fingers[-1])]
    first, last = (np.degrees(np.arctan2(way @ palm.thumbwards, way @ palm.knuckles)) for way in ways)
    return float(first - last)


def _link(bones: Bones, start: int, end: int) -> np.ndarray:
    """Return the unit vector (3,) from head to head."""
    way = bones.heads[end] - bones.heads[start]
    return way / max(np.linalg.norm(way), 1e-12)


def _bend(axis: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    """Return rotations (frames, 4) about ``axis`` (3,)."""
    return quaternion.about(np.broadcast_to(axis, (len(degrees), 3)), np.radians(degrees))
