"""Hands of recorded clips: knuckles, palms and handshapes from the positions of all finger joints."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from . import rotation, smartbody


@dataclass(frozen=True)
class FingerJoints:
    """Joint names of a family of skeletons: format strings of the wrist and the finger joints, and what they insert."""

    wrist: str
    joint: str
    sides: tuple[str, str]
    fingers: tuple[str, str, str, str, str]
    joints: tuple[str, ...]
    thumbs: bool = True
    """Whether the thumb joints are anatomically right."""

    def wrist_of(self, side: int) -> str:
        """Return the wrist's joint, 0 left and 1 right."""
        return self.wrist.format(side=self.sides[side])

    def chain(self, side: int, finger: int) -> tuple[str, ...]:
        """Return a finger's joints from the knuckle on; fingers: index, middle, ring, little, thumb."""
        names = {"side": self.sides[side], "finger": self.fingers[finger]}
        return tuple(self.joint.format(**names, joint=joint) for joint in self.joints)

    def all(self) -> set[str]:
        """Return every name."""
        chains = (self.chain(side, finger) for side in (0, 1) for finger in range(5))
        return {self.wrist_of(0), self.wrist_of(1)}.union(*chains)


SMARTBODY = FingerJoints(
    "JtWrist{side}", "Jt{finger}{joint}{side}", ("Lf", "Rt"), ("Index", "Middle", "Ring", "Little", "Thumb"), (*"ABC",)
)
PERCEPTION_NEURON = FingerJoints(
    "{side}Hand", "{side}Hand{finger}{joint}", ("Left", "Right"), ("Index", "Middle", "Ring", "Pinky", "Thumb"), (*"123",),
    thumbs=False,
)  # fmt: skip


def read_hands(
    joints: Sequence[smartbody.Joint], recording: smartbody.Recording | None, names: FingerJoints, straight: np.ndarray
) -> Hands:
    """Return the hands of a recording (of the rest pose, if None).

    ``straight`` ``(frames, 4)`` rotates the recording's axes to the body's.
    """
    positions, rotations = smartbody.forward_kinematics(list(joints), recording, names.all())
    rest = smartbody.forward_kinematics(list(joints), None, names.all())

    def canonical(vector: np.ndarray) -> np.ndarray:
        return skeleton.y_up_to_canonical(rotation.rotate(straight, vector))

    hands = [_hand(positions, rotations, rest, names, side) for side in (0, 1)]
    along, normal = (np.stack([canonical(hand[part]) for hand in hands], 1) for part in (0, 1))
    return Hands.of(along, normal, np.stack([hand[2] for hand in hands], 1))


_ByJoint = dict[str, np.ndarray]


def _hand(
    positions: _ByJoint, rotations: _ByJoint, rest: tuple[_ByJoint, _ByJoint], names: FingerJoints, side: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return knuckles ``(frames, 3)``, palm normal ``(frames, 3)`` and handshape ``(frames, 12)`` of one hand."""
    wrist, chains = names.wrist_of(side), [names.chain(side, finger) for finger in range(5)]
    roots = np.stack([positions[chain[0]] for chain in chains[:4]], 1)
    along = skeleton.normalize(roots.mean(1) - positions[wrist])
    sign = 1.0 if side == 0 else -1.0  # y up, left at +x: a left palm looks down where fingers point left, thumbs forward
    normal = skeleton.normalize(np.cross(along, roots[:, 0] - roots[:, 3])) * sign
    normal = skeleton.normalize(normal - along * np.sum(normal * along, -1, keepdims=True))
    thumbwards = -sign * np.cross(along, normal)
    shape = []
    for chain in chains[:4]:
        first = skeleton.normalize(positions[chain[1]] - positions[chain[0]])
        second = skeleton.normalize(positions[chain[2]] - positions[chain[1]])
        axis = skeleton.normalize(np.cross(first, normal))
        shape.append(np.degrees(np.arcsin(np.clip(np.sum(first * normal, -1), -1, 1))))
        middle = np.degrees(np.arctan2(np.sum(np.cross(first, second) * axis, -1), np.sum(first * second, -1)))
        shape.append(middle + _last_bend(rotations, rest, chain))
    shape += _thumb(positions, rotations, rest, chains[4], (along, normal, thumbwards))
    bones = [positions[chain[1]] - positions[chain[0]] for chain in (chains[0], chains[3])]
    first, last = (np.degrees(np.arctan2(np.sum(bone * thumbwards, -1), np.sum(bone * along, -1))) for bone in bones)
    bent = np.maximum(shape[0], shape[6])
    # the angle in the plane of the palm does not measure the spread of bent fingers
    return along, normal, np.stack([*shape, (first - last) * np.clip((75 - bent) / 40, 0, 1)], -1)


def _last_bend(rotations: _ByJoint, rest: tuple[_ByJoint, _ByJoint], chain: tuple[str, ...]) -> np.ndarray:
    """Return the degrees ``(frames,)`` that a finger's last joint is bent from its rest."""
    own = rotation.multiply(rotation.conjugate(rotations[chain[1]]), rotations[chain[2]])
    still = rotation.multiply(rotation.conjugate(rest[1][chain[1]]), rest[1][chain[2]])
    turn = rotation.multiply(own, rotation.conjugate(still))
    return np.degrees(2 * np.arctan2(np.linalg.norm(turn[..., 1:], axis=-1), np.abs(turn[..., 0])))


def _thumb(
    positions: _ByJoint,
    rotations: _ByJoint,
    rest: tuple[_ByJoint, _ByJoint],
    chain: tuple[str, ...],
    frame: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> list[np.ndarray]:
    """Return the thumb's columns of the handshape in degrees ``(frames,)``: abduction, opposition and bend.

    ``frame``: directions along the hand, of the palm's normal, and towards the thumb.
    """
    along, normal, thumbwards = frame
    first = skeleton.normalize(positions[chain[1]] - positions[chain[0]])
    second = skeleton.normalize(positions[chain[2]] - positions[chain[1]])
    out = np.degrees(np.arctan2(np.sum(first * thumbwards, -1), np.sum(first * along, -1)))
    opposed = np.degrees(np.arcsin(np.clip(np.sum(first * normal, -1), -1, 1)))
    bend = np.degrees(np.arccos(np.clip(np.sum(first * second, -1), -1, 1)))
    return [out, opposed, bend + _last_bend(rotations, rest, chain)]
