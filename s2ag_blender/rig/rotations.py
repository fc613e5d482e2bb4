"""Rotation helpers of the control-rig solver; quaternions are (w, x, y, z)."""

import numpy as np

from ...core.motion import quaternion


def interpolate(rotations: np.ndarray, frames: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Interpolate rotations ``(frames, 4)`` at ascending ``frames`` to frames ``at`` (n,); ends are extended."""
    place = np.interp(at, frames, np.arange(len(frames)))
    index = np.minimum(place.astype(int), max(len(frames) - 2, 0))
    after = np.minimum(index + 1, len(frames) - 1)
    return quaternion.slerp(rotations[index], rotations[after], (place - index))


def angle(q: np.ndarray) -> np.ndarray:
    """Return the angles (...) of rotations (..., 4), in radians, 0..pi."""
    return 2.0 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))


def with_axis_turned(tilt: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the rotations ``turn`` (frames, 4) about their axes rotated by ``tilt``."""
    return np.concatenate([turn[..., :1], quaternion.rotate(tilt, turn[..., 1:])], -1)


def axis(turn: np.ndarray) -> np.ndarray:
    """Return the unit axes (frames, 3) of rotations, each taken the short way round."""
    vector = np.where(turn[..., :1] < 0, -turn[..., 1:], turn[..., 1:])
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(length > 1e-9, vector / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])


def to_armature(rest: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Return a rotation in a bone's rest frame as a rotation in armature space."""
    return quaternion.multiply(rest, quaternion.multiply(rotation, quaternion.conjugate(rest)))
