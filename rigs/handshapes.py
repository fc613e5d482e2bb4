"""Handshapes onto a rig's fingers: degrees away from the palm's plane and between links, whatever they have at rest."""

import numpy as np

from ..core.motion import handshape, quaternion
from . import fingers
from .palms import Palm
from .plain import Bones

MIDDLE = 0.6
"""Share of what a finger bends beyond its knuckle that is in its middle joint."""
STUMP = 0.75
"""Share of that for a finger that has one joint there."""
_PLACES = {2: (0.5, -0.5), 3: (0.5, 0.1, -0.5), 4: (0.5, 0.15, -0.17, -0.5), 5: (0.5, 0.25, 0.0, -0.25, -0.5)}
"""Where fingers of a hand with so many lie in its spread."""
_THUMB = np.radians(45.0)
"""The most that a thumb's first joint is turned from rest."""


def rotations(bones: Bones, palm: Palm, shape: np.ndarray, strength: float = 1.0) -> dict[str, np.ndarray]:
    """Rotations ``{bone: (frames, 4)}`` in the bones' own rest spaces that give a hand the handshapes (frames, 12), degrees.

    ``strength`` (0..1) scales them. A hand of fewer fingers takes those of the nearest places.
    """
    hand = palm.fingers
    if hand is None or strength <= 0:
        return {}
    turns = {}
    count = len(hand.fingers)
    columns = np.linspace(0, 3, count).round().astype(int)
    fan = _fan(bones, palm)
    for place, chain in enumerate(hand.fingers):
        base = handshape.columns(shape, "base")[:, columns[place]]
        rest = handshape.columns(shape, "rest")[:, columns[place]]
        aside = _PLACES[count][place] * (handshape.column(shape, "spread") - fan)
        turns |= _finger(bones, palm, chain, base, rest, aside)
    if len(hand.thumb) >= 2:
        turns |= _thumb(bones, palm, hand.thumb, shape)
    found = {}
    for row, turn in turns.items():
        own = bones.rest[row]
        if not bones.inherits[row]:
            continue
        if isinstance(turn, tuple):  # a hinge: its axis is turned once, not every frame
            axis, angles = turn
            found[bones.names[row]] = quaternion.about(quaternion.rotate(quaternion.conjugate(own), axis), strength * angles)
            continue
        turn = quaternion.power(turn, strength) if strength < 1 else turn
        local = quaternion.multiply(quaternion.conjugate(own), quaternion.multiply(turn, own))
        found[bones.names[row]] = quaternion.continuous(local)
    return found


def _finger(bones: Bones, palm: Palm, chain, base, rest, aside) -> dict[int, np.ndarray | tuple]:
    """Of up to three joints turns (frames, 4) in armature space, or an axis (3,) there and angles (frames,) in radians."""
    first = _link(bones, chain[0], chain[1])
    axis = np.cross(first, palm.normal)
    axis = axis / max(np.linalg.norm(axis), 1e-6)
    before = fingers.rest_bend(bones, chain, axis)[1:]
    bent = np.degrees(np.arcsin(np.clip(first @ palm.normal, -1, 1)))
    sideways = quaternion.about(palm.normal, np.radians(aside) * np.sign(np.cross(palm.normal, first) @ palm.thumbwards or 1))
    turns = {chain[0]: quaternion.multiply(sideways, _bend(axis, base - bent))}
    shares = (MIDDLE, 1 - MIDDLE) if len(chain) > 2 else (STUMP,)
    for row, share, there in zip(chain[1:3], shares, before, strict=True):
        turns[row] = axis, np.radians(share * rest - there)
    return turns


def _thumb(bones: Bones, palm: Palm, chain, shape) -> dict[int, np.ndarray | tuple]:
    first = _link(bones, chain[0], chain[1])
    out, opposed = (np.radians(handshape.column(shape, name)) for name in ("thumb_out", "thumb_opposition"))
    flat = np.stack([np.cos(opposed) * np.cos(out), np.sin(opposed), np.cos(opposed) * np.sin(out)], -1)
    swing = quaternion.swing(np.broadcast_to(first, flat.shape), flat @ palm.frame.T)
    angle = 2 * np.arccos(np.clip(np.abs(swing[:, 0]), 0, 1))
    turns = {chain[0]: quaternion.power(swing, np.minimum(1.0, _THUMB / np.maximum(angle, 1e-6)))}
    along = _link(bones, chain[0], chain[:3][-1])
    axis = np.cross(along, 0.6 * palm.normal - 0.8 * palm.thumbwards)
    axis = axis / max(np.linalg.norm(axis), 1e-6)
    before = fingers.rest_bend(bones, chain, axis)[1:]
    shares = (0.5, 0.5) if len(chain) > 2 else (0.7,)
    for row, share, there in zip(chain[1:3], shares, before, strict=True):
        turns[row] = axis, np.radians(share * handshape.column(shape, "thumb_bend") - there)
    return turns


def _fan(bones: Bones, palm: Palm) -> float:
    """Degrees between the first and the last finger at rest, seen on the palm."""
    ways = [_link(bones, chain[0], chain[1]) for chain in (palm.fingers.fingers[0], palm.fingers.fingers[-1])]
    first, last = (np.degrees(np.arctan2(way @ palm.thumbwards, way @ palm.knuckles)) for way in ways)
    return float(first - last)


def _link(bones: Bones, start: int, end: int) -> np.ndarray:
    way = bones.heads[end] - bones.heads[start]
    return way / max(np.linalg.norm(way), 1e-12)


def _bend(axis: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    return quaternion.about(np.broadcast_to(axis, (len(degrees), 3)), np.radians(degrees))
