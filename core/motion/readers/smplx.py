"""Reads SMPL-X motion as BEAT2 stores it: axis-angle poses in ``.npz``."""

from os import PathLike
from pathlib import Path

import numpy as np

from ... import npz
from ...errors import CorpusUnreadable
from .. import quaternion
from .ten_joints import Posed, chain, check

LARGEST = 1_000_000_000
"""Bytes that a motion or a body model may unpack to, at most; SMPL-X's own model takes half of that."""
NAMES = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle", "right_ankle", "spine3",
    "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head", "left_shoulder", "right_shoulder", "left_elbow",
    "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
"""The first 22 joints of SMPL-X; y up, facing z, left at +x."""
PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
OFFSETS = np.array(
    [
        (0, 0, 0), (0.06, -0.09, 0), (-0.06, -0.09, 0), (0, 0.11, -0.02), (0.04, -0.38, 0), (-0.04, -0.38, 0), (0, 0.14, 0.02),
        (0, -0.4, -0.04), (0, -0.4, -0.04), (0, 0.05, 0.02), (0.03, -0.06, 0.12), (-0.03, -0.06, 0.12), (0, 0.2, -0.05),
        (0.05, 0.11, -0.03), (-0.05, 0.11, -0.03), (0, 0.08, 0.05), (0.12, 0.04, -0.01), (-0.12, 0.04, -0.01),
        (0.26, -0.01, -0.02), (-0.26, -0.01, -0.02), (0.25, 0.01, 0), (-0.25, 0.01, 0),
    ]
)  # fmt: skip
"""Rest offsets of an average body, metres, rounded: directions hardly depend on them, the model may not be redistributed."""


def read(path: str | PathLike, offsets: np.ndarray = OFFSETS) -> tuple[Posed, float]:
    """Return the skeleton in motion and its frames per second.

    Reads ``poses`` (frames, 66 or more) and, where they are there, ``trans`` and ``mocap_frame_rate``.
    Raises :class:`CorpusUnreadable`."""
    path = Path(path)
    try:
        with npz.open_arrays(path, LARGEST) as data:
            poses = np.asarray(data["poses"], float)
            root = np.asarray(data["trans"], float) if "trans" in data else np.zeros((len(poses), 3))
            fps = float(data["mocap_frame_rate"]) if "mocap_frame_rate" in data else 30.0
            check(poses, len(poses), fps)
            check(root, len(poses), fps)
    except (OSError, npz.NotArrays) as error:
        raise CorpusUnreadable(f"{path} is no SMPL-X motion: {' '.join(str(error).split())[:100]}.", "Get it again.") from error
    if poses.ndim != 2 or poses.shape[1] < 3 * len(NAMES) or root.shape != (len(poses), 3) or not len(poses):
        message = f"{path} holds poses of shape {poses.shape}, not (frames, {3 * len(NAMES)} or more)."
        raise CorpusUnreadable(message, "Get it again.")
    local = rotations(poses[:, : 3 * len(NAMES)].reshape(len(poses), -1, 3))
    return Posed(NAMES, *chain(offsets, PARENTS, local, root + offsets[0])), fps


def rotations(axis_angles: np.ndarray) -> np.ndarray:
    """Return rotation matrices ``(..., 3, 3)`` of rotation vectors ``(..., 3)`` in radians."""
    angle = np.linalg.norm(axis_angles, axis=-1)
    axis = axis_angles / np.maximum(angle, 1e-12)[..., None]
    half = np.concatenate([np.cos(angle / 2)[..., None], axis * np.sin(angle / 2)[..., None]], -1)
    return quaternion.to_matrix(half)
