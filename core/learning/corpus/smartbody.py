"""Reads SmartBody's text formats: skeletons (``.sk``, and ``.bvh`` hierarchies) and motions (``.skm``); forward kinematics.

A joint's rotation is its parent's, then its fixed pre-rotation, then the exponential map of its ``Quat`` channel; its
position is its parent's plus the parent's rotation of (offset + position channels). y up, left at +x.
"""

import re
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from . import rotation

PHASES = ("ready", "strokeStart", "emphasis", "stroke", "relax")
_PHASE = re.compile(r"(\w+?)(?:\s+start)?\s+time:\s*([-\d.eE]+)")
_CHANNEL_WIDTHS = {"XPos": 1, "YPos": 1, "ZPos": 1, "Quat": 3}


@dataclass(frozen=True)
class Joint:
    """One joint: index of its parent (-1 for the root), offset ``(3,)`` and pre-rotation quaternion ``(4,)``."""

    name: str
    parent: int
    offset: np.ndarray
    prerotation: np.ndarray


@dataclass(frozen=True)
class Recording:
    """A motion file: ``times`` ``(frames,)`` in seconds, channels by (joint, kind), times of gesture phases by name."""

    times: np.ndarray
    channels: dict[tuple[str, str], np.ndarray]
    phases: dict[str, float]


def load_skeleton(path: str | PathLike) -> list[Joint]:
    """Read the joints of a ``.sk`` or ``.bvh`` file, parents before children. Raises ``ValueError`` if it holds none."""
    joints: list[Joint] = []
    open_joints: list[int] = []
    pending = -1
    for line in Path(path).read_text(errors="replace").splitlines():
        tokens = line.replace("{", " { ").replace("}", " } ").split()
        for position, token in enumerate(tokens):
            if token.lower() in ("root", "joint") and position == 0:
                joints.append(Joint(tokens[1], open_joints[-1] if open_joints else -1, np.zeros(3), rotation.IDENTITY))
                pending = len(joints) - 1
            elif token == "End" and position == 0:
                pending = -1
            elif token == "{":
                open_joints.append(pending)
            elif token == "}":
                open_joints.pop()
            elif token.lower() == "offset" and open_joints[-1] >= 0:
                _set_fields(joints, open_joints[-1], offset=np.array(tokens[position + 1 : position + 4], float))
            elif token == "prerot":
                _set_fields(joints, open_joints[-1], prerotation=_prerotation(tokens[position + 1 :]))
            elif token == "MOTION":
                return joints
    if not joints:
        raise ValueError(f"no joints in {path}")
    return joints


def _set_fields(joints: list[Joint], index: int, **fields: np.ndarray) -> None:
    joints[index] = Joint(**{**joints[index].__dict__, **fields})


def _prerotation(tokens: list[str]) -> np.ndarray:
    """Return the quaternion of ``axis X Y Z ang DEGREES``."""
    axis = np.array(tokens[1:4], float)
    length = np.linalg.norm(axis)
    return rotation.from_vector(axis / length * np.radians(float(tokens[5]))) if length > 1e-9 else rotation.IDENTITY


def load_recording(path: str | PathLike) -> Recording:
    """Read a ``.skm`` file. Raises ``ValueError`` where frames and channels disagree."""
    layout: list[tuple[str, str]] = []
    times, frames, phases = [], [], {}
    for line in Path(path).read_text(errors="replace").splitlines():
        tokens = line.split()
        if tokens and tokens[0] == "kt":
            times.append(float(tokens[1]))
            frames.append(np.array(tokens[3:], float))
        elif len(tokens) == 2 and tokens[1] in _CHANNEL_WIDTHS:
            layout.append((tokens[0], tokens[1]))
        elif match := _PHASE.match(line.strip()):
            phases[match.group(1)] = float(match.group(2))
    ends = np.cumsum([_CHANNEL_WIDTHS[kind] for _, kind in layout])
    table = np.array(frames)
    if not len(ends) or table.ndim != 2 or table.shape[1] != ends[-1]:
        raise ValueError(f"{path}: {table.shape} values for {len(layout)} channels")
    return Recording(np.array(times), dict(zip(layout, np.split(table, ends[:-1], axis=1), strict=True)), phases)


def forward_kinematics(
    joints: list[Joint], recording: Recording | None, joint_names: set[str]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return world positions ``(frames, 3)`` and rotations ``(frames, 4)`` of the named joints and their ancestors.

    Without a recording: the skeleton's rest pose, one frame.
    """
    channels = recording.channels if recording else {}
    frames = len(recording.times) if recording else 1
    indices: set[int] = set()
    for index, joint in enumerate(joints):
        while joint.name in joint_names and index >= 0:
            indices.add(index)
            index = joints[index].parent
    positions: dict[int, np.ndarray] = {}
    rotations: dict[int, np.ndarray] = {}
    for index in sorted(indices):
        joint = joints[index]
        offset = np.tile(joint.offset, (frames, 1))
        for axis, kind in enumerate(("XPos", "YPos", "ZPos")):
            if (joint.name, kind) in channels:
                offset[:, axis] += channels[joint.name, kind][:, 0]
        turn = np.tile(joint.prerotation, (frames, 1))
        if (joint.name, "Quat") in channels:
            turn = rotation.multiply(turn, rotation.from_vector(channels[joint.name, "Quat"]))
        if joint.parent < 0:
            positions[index], rotations[index] = offset, turn
        else:
            positions[index] = positions[joint.parent] + rotation.rotate(rotations[joint.parent], offset)
            rotations[index] = rotation.multiply(rotations[joint.parent], turn)
    names = {index: joints[index].name for index in indices}
    return {names[i]: p for i, p in positions.items()}, {names[i]: r for i, r in rotations.items()}
