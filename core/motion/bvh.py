"""A motion as BVH: the plain ten-joint skeleton, readable by any animation program.

Frame: y up, z forward, left at +x. Unit: metres unless ``unit`` says otherwise. One joint for each of the nine edges,
named as Mixamo does so that rigs and programs recognise them, below still hips; hands turn where the motion has any, and
have no fingers. The rest pose stretches the arms out to the sides in a T, while torso, neck, head and clavicles lie along
the data's mean, so that no rotation means an average posture.
"""

import os

import numpy as np

from ...rigs import quaternion
from ...rigs.goals import NEUTRAL, Options
from ...rigs.plain import Bones, Mapping
from ...rigs.retarget import solve
from ..files import whole_file
from . import skeleton
from .motion import Motion

HIPS_HEIGHT = 0.9
SPINE_OFFSET = 0.1
HAND = 0.1
"""Metres: the hips above the floor, the spine joint above the hips, the length of a hand."""

JOINT_OF_EDGE = {
    "torso": "Spine",
    "neck": "Neck",
    "head": "Head",
    "left_clavicle": "LeftShoulder",
    "left_upper_arm": "LeftArm",
    "left_forearm": "LeftForeArm",
    "right_clavicle": "RightShoulder",
    "right_upper_arm": "RightArm",
    "right_forearm": "RightForeArm",
}
"""The BVH joint that stands at an edge's start and turns it."""

_JOINTS = (  # name, parent, the edge that leads to it
    ("Hips", None, None),
    ("Spine", "Hips", None),
    ("Neck", "Spine", "torso"),
    ("Head", "Neck", "neck"),
    ("LeftShoulder", "Spine", "torso"),
    ("LeftArm", "LeftShoulder", "left_clavicle"),
    ("LeftForeArm", "LeftArm", "left_upper_arm"),
    ("LeftHand", "LeftForeArm", "left_forearm"),
    ("RightShoulder", "Spine", "torso"),
    ("RightArm", "RightShoulder", "right_clavicle"),
    ("RightForeArm", "RightArm", "right_upper_arm"),
    ("RightHand", "RightForeArm", "right_forearm"),
)
_ENDS = {"Head": "head", "LeftHand": "left_forearm", "RightHand": "right_forearm"}
_CROWN = "crown"  # a bone that only the solver sees: where the head ends
_ORDER = "YXZ"  # as Blender names it: y turns first; BVH lists the same from the outside in, Z X Y


def save(motion: Motion, path: str | os.PathLike, unit: float = 1.0) -> None:
    """Write ``motion`` at its own frame rate to ``path``, whole or not at all; ``unit`` is a metre's length in the file.

    Raises :class:`OutputUnwritable`.
    """
    text = hierarchy(unit) + frames(motion, unit)
    with whole_file(path) as temporary:
        temporary.write_text(text, "ascii")


def hierarchy(unit: float = 1.0) -> str:
    """The HIERARCHY section: joints, offsets and channels."""
    lines = ["HIERARCHY"]
    _joint(lines, "Hips", "", unit)
    return "\n".join(lines) + "\n"


def frames(motion: Motion, unit: float = 1.0) -> str:
    """The MOTION section: degrees with five decimals."""
    angles = np.degrees(_angles(motion))[..., [2, 0, 1]]
    hips = np.tile([0.0, HIPS_HEIGHT * unit, 0.0], (len(angles), 1))
    rows = np.concatenate([hips, angles.reshape(len(angles), -1)], -1)
    body = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in rows)
    return f"MOTION\nFrames: {len(rows)}\nFrame Time: {1.0 / motion.fps:.9f}\n{body}\n"


def _joint(lines: list[str], name: str, indent: str, unit: float) -> None:
    is_root = name == "Hips"
    channels = "6 Xposition Yposition Zposition" if is_root else "3"
    lines += [
        f"{indent}{'ROOT' if is_root else 'JOINT'} {name}",
        f"{indent}{{",
        f"{indent}\tOFFSET {_offset_text(_offset(name), unit)}",
        f"{indent}\tCHANNELS {channels} Zrotation Xrotation Yrotation",
    ]
    for child, parent, _ in _JOINTS:
        if parent == name:
            _joint(lines, child, indent + "\t", unit)
    if name in _ENDS:
        end = f"{indent}\t\tOFFSET {_offset_text(_end(name), unit)}"
        lines += [f"{indent}\tEnd Site", f"{indent}\t{{", end, f"{indent}\t}}"]
    lines.append(f"{indent}}}")


def _offset_text(offset: np.ndarray, unit: float) -> str:
    return " ".join(f"{value * unit + 0.0:.6f}" for value in offset)


def _rest() -> np.ndarray:
    """Rest directions (9, 3), y up: the data's mean with arms stretched out to the sides."""
    rest = skeleton.canonical_to_y_up(NEUTRAL).astype(float)
    rest[[4, 5]], rest[[7, 8]] = [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]
    return rest


def _offset(name: str) -> np.ndarray:
    edge = next(edge for joint, _, edge in _JOINTS if joint == name)
    if edge is None:
        return np.array([0.0, SPINE_OFFSET if name == "Spine" else 0.0, 0.0])
    row = skeleton.EDGE_NAMES.index(edge)
    return _rest()[row] * skeleton.LENGTHS[row]


def _end(name: str) -> np.ndarray:
    row = skeleton.EDGE_NAMES.index(_ENDS[name])
    return _rest()[row] * (skeleton.LENGTHS[row] if name == "Head" else HAND)


def _bones() -> Bones:
    """The skeleton at rest, joints as bones whose axes are the file's own."""
    names = (*(name for name, _, _ in _JOINTS), _CROWN)
    parents = np.array([-1 if above is None else names.index(above) for _, above, _ in _JOINTS] + [names.index("Head")])
    matrices = np.tile(np.eye(4), (len(names), 1, 1))
    for row, name in enumerate(names):
        above = matrices[parents[row], :3, 3] if row else np.array([0.0, HIPS_HEIGHT, 0.0])
        matrices[row, :3, 3] = above + (_end("Head") if name == _CROWN else _offset(name))
    return Bones(names, parents, matrices, np.full(len(names), HAND))


def _angles(motion: Motion) -> np.ndarray:
    """Euler angles (frames, joints, 3) as x, y, z in radians."""
    chains = {edge: (joint,) for edge, joint in JOINT_OF_EDGE.items()}
    chains |= {"left_hand": ("LeftHand",), "right_hand": ("RightHand",), "crown": (_CROWN,)}
    options = Options(clavicle=1.0, aimed=frozenset(skeleton.EDGE_NAMES), palms=0.0, clear_body=0.0, limits=False)
    rotations = solve(_bones(), Mapping(chains, hips="Hips"), motion.directions, motion.fps, options, motion.hands)
    still = np.zeros((len(motion.directions), 3))
    return np.stack([quaternion.to_euler(rotations[name], _ORDER) if name in rotations else still for name, _, _ in _JOINTS], 1)
