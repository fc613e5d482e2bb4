"""Hand orientation: from directions of knuckles and palms to the rotations of forearm and wrist, within human limits."""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from . import fingers, limits
from .arms import angle_about
from .fingers import SIDES
from .proportions import EASE, calm, smooth
from .skeleton import Bones, Mapping

PRONATION = np.radians([-115.0, 115.0])
"""Twist of a forearm in radians, from a palm that faces along the elbow's hinge (thumbs forward in a T pose)."""
FLEXION = np.radians([-85.0, 85.0])
DEVIATION = np.radians([-42.0, 42.0])
"""Bend of a wrist in radians: towards the palm and the back of the hand, towards the thumb and the little finger."""
FOREARM_TWIST_SHARE = 0.6
"""Share of the twist that goes to a forearm without twist bones; the wrist takes the rest."""


@dataclass(frozen=True)
class Palm:
    """A hand at rest in armature space.

    Unit vectors (3,): ``knuckles`` from the wrist, ``normal`` out of the palm, ``thumbwards`` at right angles to both.
    ``fingers`` is None where they are unknown. ``neutral`` (radians) is the palm's twist about the forearm, measured from
    the middle of its range."""

    knuckles: np.ndarray
    normal: np.ndarray
    thumbwards: np.ndarray
    fingers: fingers.Hand | None
    neutral: float

    @property
    def frame(self) -> np.ndarray:
        """The columns ``knuckles``, ``normal``, ``thumbwards`` (3, 3)."""
        return np.stack([self.knuckles, self.normal, self.thumbwards], -1)


def at_rest(
    bones: Bones, mapping: Mapping, side: str, hand: fingers.Hand | None, guess: np.ndarray, middle: np.ndarray
) -> Palm:
    """Return the palm on ``side``: by its knuckles, or without a ``hand`` by its bone and the estimated normal ``guess`` (3,).

    ``middle`` (3,) is the normal of a palm in the middle of the forearm's range."""
    fore = mapping.segment(bones, f"{side}_forearm")
    if hand is not None:
        heads = bones.heads
        wrist = heads[bones.row(mapping.chains[f"{side}_hand"][0])]
        roots = heads[[chain[0] for chain in hand.fingers]]
        along, normal = fingers.unit(roots.mean(0) - wrist), np.cross(roots[0] - roots[-1], roots.mean(0) - wrist)
        normal = fingers.unit(normal) * np.sign(normal @ hand.palm or 1.0)
    else:
        along = _hand_direction(bones, mapping, side, fore)
        normal = fingers.unit(guess - along * (along @ guess))
    neutral = float(angle_about(fore, middle, normal))
    return Palm(along, normal, -SIDES[side] * np.cross(along, normal), hand, neutral)


def hand_rotation(palm: Palm, knuckles: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return D (frames, 4) of a hand with these directions of knuckles and palm (frames, 3), which are at right angles."""
    goal = np.stack([knuckles, normals, np.cross(knuckles, normals)], -1)
    rest = np.stack([palm.knuckles, palm.normal, np.cross(palm.knuckles, palm.normal)], -1)
    return quaternion.from_matrix(goal @ rest.T)


def limit_wrist(
    palm: Palm, target: np.ndarray, fore: np.ndarray, aimed: np.ndarray, fps: float, free: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return D (frames, 4) of a hand within the wrist's range, and the twist (frames,) of its forearm in radians.

    ``target`` is the target D, ``fore`` (frames, 3) the forearm's direction and ``aimed`` its D without twist; if ``free``,
    nothing is limited."""
    if not free:
        axes = quaternion.rotate(target[:, None], palm.frame.T)
        along, out, aside = (np.sum(axes[:, index] * fore, -1) for index in range(3))
        bent = limits.soft_limit(np.arctan2(out, along), FLEXION)
        sideways = limits.soft_limit(np.arcsin(np.clip(aside, -1, 1)), DEVIATION)
        reached = np.stack([np.cos(sideways) * np.cos(bent), np.cos(sideways) * np.sin(bent), np.sin(sideways)], -1)
        limited = np.sum(axes * reached[..., None], 1)
        target = quaternion.multiply(quaternion.swing(limited, fore), target)
    twist = twist_about(fore, quaternion.multiply(target, quaternion.conjugate(aimed)))
    if free:
        return target, twist
    # A hand that came round to its range from the far side is within it again; what is brief stays at the same end.
    rounds = np.round((twist + palm.neutral) / (2 * np.pi))[:, None]
    rounds = smooth(np.round(smooth(rounds, fps)), EASE * fps)[:, 0]
    allowed = calm(limits.soft_limit(twist + palm.neutral - 2 * np.pi * rounds, PRONATION), fps) - palm.neutral
    return quaternion.multiply(quaternion.about(fore, allowed - twist), target), allowed


def twist_about(axis: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the twist (frames,) of rotations (frames, 4) about ``axis`` (frames, 3) in radians, unwrapped over time."""
    angle = 2.0 * np.arctan2(np.sum(turn[..., 1:] * axis, -1), turn[..., 0])
    angle = np.unwrap(angle)
    return angle - 2 * np.pi * np.round(np.median(angle) / (2 * np.pi))


def _hand_direction(bones: Bones, mapping: Mapping, side: str, fore: np.ndarray) -> np.ndarray:
    """Return the direction (3,) of a hand without fingers at rest: its bone's, if near the forearm's, else the forearm's."""
    chain = mapping.chains.get(f"{side}_hand")
    if not chain:
        return fore
    row = bones.row(chain[0])
    own = bones.tails[row] - bones.heads[row]
    length = np.linalg.norm(own)
    return own / length if length > 1e-9 and own @ fore > 0.9 * length else fore
