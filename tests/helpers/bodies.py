"""Bodies for the tests of retargeting: joint positions with names and parents, and performances to lay on them.

Positions are in Blender's frame (z up, facing -y, left at +x), centimetres; ``turned`` puts a body into another frame.
"""

from dataclasses import dataclass

import numpy as np
from s2ag.core.motion import quaternion, skeleton
from s2ag.rigs.skeleton import Bones, Mapping

ARM_EDGES = ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")
Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # rows: where x, y, z of the armature's frame lie
BACKWARDS = np.diag([-1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Body:
    """Joints ``{name: (position, parent)}`` and which of them begin which part."""

    joints: dict
    chains: dict
    hips: str = "hips"

    def turned(self, frame: np.ndarray) -> "Body":
        """The same body with positions seen in another frame."""
        joints = {name: (frame @ np.array(at, float), above) for name, (at, above) in self.joints.items()}
        return Body(joints, self.chains, self.hips)

    @property
    def mapping(self) -> Mapping:
        return Mapping(self.chains, hips=self.hips)

    def bones(self, seed: int = 0) -> Bones:
        """Bones with axes and rolls that have nothing to do with the chain of joints."""
        names = tuple(self.joints)
        random = np.random.default_rng(seed)
        turns = random.normal(size=(len(names), 4))
        matrices = np.tile(np.eye(4), (len(names), 1, 1))
        matrices[:, :3, :3] = quaternion.to_matrix(turns / np.linalg.norm(turns, axis=-1, keepdims=True))
        matrices[:, :3, 3] = [at for at, _ in self.joints.values()]
        parents = np.array([names.index(above) if above else -1 for _, above in self.joints.values()])
        return Bones(names, parents, matrices, np.full(len(names), 8.0))


def body(pose: str = "A") -> Body:
    """A person in A, T or hanging (I) pose, with three spine bones, and bones in between that belong to no part."""
    joints = {
        "root": ((0, 0, 0), None),
        "hips": ((0, 1, 95), "root"),
        "spine1": ((0, 0, 105), "hips"),
        "spine2": ((0, 0, 118), "spine1"),
        "spine3": ((0, 1, 132), "spine2"),
        "neck": ((0, 2, 150), "spine3"),
        "head": ((0, 0, 160), "neck"),
    }
    chains = {"torso": ("spine1", "spine2", "spine3"), "neck": ("neck",), "head": ("head",)}
    reach = {"T": ((27, 0, 0), (52, 0, 0)), "A": ((20, 1, -19), (38, -3, -37)), "I": ((2, 1, -28), (4, -2, -53))}[pose]
    for side, x in (("left", 1), ("right", -1)):
        elbow, wrist = (np.array(step) * (x, 1, 1) for step in reach)
        shoulder = np.array((18 * x, 2, 146))
        joints |= {
            f"{side}_clavicle": ((3 * x, 0, 147), "spine3"),
            f"{side}_upper": (shoulder, f"{side}_clavicle"),
            f"{side}_helper": (shoulder + 0.4 * elbow, f"{side}_upper"),
            f"{side}_fore": (shoulder + elbow, f"{side}_helper"),
            f"{side}_twist": (shoulder + 0.5 * (elbow + wrist), f"{side}_fore"),
            f"{side}_hand": (shoulder + wrist, f"{side}_twist"),
        }
        parts = {"clavicle": "clavicle", "upper_arm": "upper", "forearm": "fore", "hand": "hand"}
        chains |= {f"{side}_{part}": (f"{side}_{name}",) for part, name in parts.items()}
    return Body(joints, chains)


def performance(frames: int = 90, seed: int = 1, size: float = 0.8) -> np.ndarray:
    """A random walk about the data's mean (frames, 9, 3): unit directions in the canonical frame."""
    steps = np.random.default_rng(seed).normal(size=(frames, 9, 3)).cumsum(0) / np.sqrt(frames)
    return skeleton.normalize(skeleton.MEAN + size * steps).astype(np.float32)


def pose(bones: Bones, rotations: dict, places: dict | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Forward kinematics by plain matrices, as Blender defines it: heads (frames, n, 3) and orientations (frames, n, 3, 3)."""
    frames = len(next(iter(rotations.values())))
    result = np.zeros((len(bones.names), frames, 4, 4))
    for row, name in enumerate(bones.names):
        basis = np.tile(np.eye(4), (frames, 1, 1))
        if name in rotations:
            basis[:, :3, :3] = quaternion.to_matrix(rotations[name])
        if name in (places or {}):
            basis[:, :3, 3] = places[name]
        above = bones.parents[row]
        start = bones.matrices[row]
        if above >= 0:
            start = result[above] @ np.linalg.inv(bones.matrices[above]) @ start
            if not bones.inherits[row]:
                start[..., :3, :3] = bones.matrices[row, :3, :3]
        result[row] = start @ basis
    return result[..., :3, 3].swapaxes(0, 1), result[..., :3, :3].swapaxes(0, 1)


def degrees(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between vectors, precise also where they are tiny."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(np.asarray(a) * b, -1)))


def turned_degrees(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles of the rotations between orientations ``(..., 3, 3)``."""
    q = quaternion.from_matrix(np.swapaxes(a, -1, -2) @ b)
    return np.degrees(2 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0])))
