"""Reads BVH files of any skeleton whose joints have known names, such as those of Trinity and ZeroEGGS."""

from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from ...files import open_file
from .. import quaternion
from .ten_joints import Posed, chain, check

LARGEST = 500_000_000
"""Bytes of a file, at most; an hour of a whole body with fingers at 60 frames a second has 300 million."""
_MAX_JOINTS_PER_CHANNEL = 4
"""Bounds joints without channels, which take as much memory as those that move."""
_AXES = {"X": 0, "Y": 1, "Z": 2}


def read(path: str | PathLike) -> tuple[Posed, float]:
    """Return the skeleton in motion and its frames per second; raises :class:`CorpusUnreadable`.

    Rotates the skeleton so that its rest pose has y up and faces z."""
    path = Path(path)
    try:
        with open_file(path) as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise ValueError(f"it is larger than {LARGEST // 1_000_000} MB")
        text = data.decode("utf-8", "replace")
        hierarchy, _, motion = text.partition("MOTION")
        names, parents, offsets, channels = _hierarchy(hierarchy.split())
        values, fps = _motion(motion.split(), sum(map(len, channels)))
        local, root = _local(values, channels, offsets)
    except OSError as error:
        raise CorpusUnreadable(
            f"{path} cannot be read: {error.strerror or error}.", "Check the name and the folder."
        ) from error
    except (ValueError, IndexError) as error:
        raise CorpusUnreadable(f"{path} is no BVH file: {error}.", "Export it again.") from error
    upright = _upright(names, parents, offsets)
    offsets, root = offsets @ upright.T, root @ upright.T
    local = upright @ local @ upright.T
    positions, rotations = chain(offsets, parents, local, root)
    return Posed(tuple(names), positions, rotations), fps


def _hierarchy(tokens: list[str]) -> tuple[list[str], list[int], np.ndarray, list[list[str]]]:
    """Return names, parents, offsets ``(n, 3)`` and channels of the joints; end sites are not joints."""
    if not tokens or tokens[0] != "HIERARCHY":
        raise ValueError("it does not begin with HIERARCHY")
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    channels: list[list[str]] = []
    open_joints: list[int] = []
    at, next_joint = 1, -1
    while at < len(tokens):
        word = tokens[at]
        if word in ("ROOT", "JOINT"):
            brace = tokens.index("{", at)  # names of some programs have spaces
            names.append(" ".join(tokens[at + 1 : brace]))
            parents.append(open_joints[-1] if open_joints else -1)
            offsets.append([0.0, 0.0, 0.0])
            channels.append([])
            next_joint, at = len(names) - 1, brace
        elif word == "End":
            next_joint, at = -1, at + 2
        elif word == "{":
            open_joints.append(next_joint)
            at += 1
        elif word == "}":
            open_joints.pop()
            at += 1
        elif word == "OFFSET":
            if open_joints[-1] >= 0:
                offsets[open_joints[-1]] = [float(value) for value in tokens[at + 1 : at + 4]]
            at += 4
        elif word == "CHANNELS":
            count = int(tokens[at + 1])
            channels[open_joints[-1]] = tokens[at + 2 : at + 2 + count]
            at += 2 + count
        else:
            raise ValueError(f"{word[:20]!r} is no word of a hierarchy")
    if open_joints or not names or parents.count(-1) != 1:
        raise ValueError("its hierarchy is not closed")
    if len(names) > _MAX_JOINTS_PER_CHANNEL * sum(map(len, channels)):
        raise ValueError("hardly any of its joints has channels")
    places = np.array(offsets)
    check(places, 1, 1.0)
    return names, parents, places, channels


def _motion(tokens: list[str], width: int) -> tuple[np.ndarray, float]:
    """Return channel values ``(frames, width)`` and frames per second of the MOTION section."""
    if tokens[:1] != ["Frames:"] or tokens[2:4] != ["Frame", "Time:"]:
        raise ValueError("it holds no motion")
    frames, interval = int(tokens[1]), float(tokens[4])
    values = np.array(tokens[5:], float)
    if frames < 1 or len(values) != frames * width:
        raise ValueError(f"it has {len(values)} numbers for {frames} frames of {width} channels")
    if not interval > 1e-9:
        raise ValueError("its frame time is no number")
    check(values, frames, 1 / interval)
    return values.reshape(frames, width), 1 / interval


def _local(values: np.ndarray, channels: list[list[str]], offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return local rotations ``(frames, n, 3, 3)`` of the joints and positions ``(frames, 3)`` of the root."""
    local = np.empty((len(values), len(channels), 3, 3))
    root = np.tile(offsets[0], (len(values), 1))
    column = 0
    for row, names in enumerate(channels):
        turn = np.tile([1.0, 0.0, 0.0, 0.0], (len(values), 1))
        for name in names:
            axis, kind = name[:1].upper(), name[1:].lower()
            if axis not in _AXES or kind not in ("rotation", "position"):
                raise ValueError(f"{name!r} is no channel")
            if kind == "rotation":
                about = quaternion.about(np.eye(3)[_AXES[axis]], np.radians(values[:, column]))
                turn = quaternion.multiply(turn, about)
            elif row == 0:
                root[:, _AXES[axis]] = values[:, column]
            column += 1
        local[:, row] = quaternion.to_matrix(turn)
    return local, root


def _upright(names: list[str], parents: list[int], offsets: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) that brings a rest pose upright along y with its left at +x."""
    still = np.tile(np.eye(3), (1, len(names), 1, 1))
    places, turns = chain(offsets, parents, still, np.zeros((1, 3)))
    posed = Posed(tuple(names), places, turns)
    rows = [posed.row(role) for role in ("left_shoulder", "right_shoulder", "hips", "head")]
    if min(rows) < 0:
        return np.eye(3)
    left, right, hips, head = places[0, rows]
    up, across = _nearest_axis(head - hips), left - right
    across = _nearest_axis(across - up * (across @ up))
    return np.stack([across, up, np.cross(across, up)])


def _nearest_axis(vector: np.ndarray) -> np.ndarray:
    """Return the signed coordinate axis (3,) closest to ``vector``."""
    axis = int(np.abs(vector).argmax())
    return np.eye(3)[axis] * (np.sign(vector[axis]) or 1.0)
