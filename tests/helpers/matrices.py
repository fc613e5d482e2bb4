"""SmartBody's forward kinematics a second time, for comparison: another reader, 4 by 4 matrices and scipy's rotations."""

import re
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

_TOKEN = re.compile(r"\b(?:root|joint)\s+(\w+)|[{}]|offset((?:\s+[-+.\deE]+){3})|axis((?:\s+[-+.\deE]+){3})\s+ang\s+(\S+)")


def read_skeleton(path: Path) -> dict[str, tuple[str, np.ndarray]]:
    """Joint -> (parent's name or "", matrix in its parent) of a ``.sk`` or ``.bvh`` file."""
    text = path.read_text().partition("MOTION")[0]
    text = re.sub(r"End Site\s*\{[^}]*\}", "", text)
    text = re.sub(r"\b(ROOT|JOINT|OFFSET)\b", lambda found: found[0].lower(), text)
    joints: dict[str, tuple[str, np.ndarray]] = {}
    open_joints, name = [], ""
    for found in _TOKEN.finditer(text):
        if found[1]:
            name = found[1]
            joints[name] = (open_joints[-1] if open_joints else "", np.eye(4))
        elif found[0] == "{":
            open_joints.append(name)
        elif found[0] == "}":
            open_joints.pop()
        elif found[2]:
            joints[open_joints[-1]][1][:3, 3] = np.array(found[2].split(), float)
        else:
            axis, angle = np.array(found[3].split(), float), float(found[4])
            length = np.linalg.norm(axis)
            if length:
                joints[open_joints[-1]][1][:3, :3] = Rotation.from_rotvec(axis / length * angle, degrees=True).as_matrix()
    return joints


def read_frames(path: Path) -> tuple[list[tuple[str, str]], np.ndarray]:
    """Columns as (joint, "XPos", "YPos", "ZPos" or "Quat", three columns each) and rows ``(frames, columns)``."""
    text = path.read_text()
    channels = re.findall(r"^(\w+) (XPos|YPos|ZPos|Quat)\s*$", text, re.MULTILINE)
    columns = [channel for channel in channels for _ in range(3 if channel[1] == "Quat" else 1)]
    rows = re.findall(r"^kt \S+\s+fr (.*)$", text, re.MULTILINE)
    return columns, np.array([row.split() for row in rows], float)


def world(joints: dict[str, tuple[str, np.ndarray]], columns: list[tuple[str, str]], row: np.ndarray) -> dict[str, np.ndarray]:
    """World matrices of all joints in one frame."""
    moved = {name: np.eye(4) for name in joints}
    shifted = {name: np.zeros(3) for name in joints}
    vectors: dict[str, list[float]] = {}
    for (name, kind), value in zip(columns, row, strict=True):
        if kind == "Quat":
            vectors.setdefault(name, []).append(value)
        else:
            shifted[name]["XYZ".index(kind[0])] = value
    for name, vector in vectors.items():
        moved[name][:3, :3] = Rotation.from_rotvec(vector).as_matrix()
    result = {"": np.eye(4)}
    for name, (parent, local) in joints.items():
        place = local.copy()
        place[:3, 3] += shifted[name]
        result[name] = result[parent] @ place @ moved[name]
    return result
