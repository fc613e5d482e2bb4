"""Quaternion functions for the corpus in addition to :mod:`s2ag.core.motion.quaternion`; unit ``(..., 4)``, w first."""

import numpy as np

from ...motion.quaternion import IDENTITY, conjugate, multiply, rotate

__all__ = ["IDENTITY", "about", "conjugate", "from_vector", "heading", "multiply", "rotate"]


def from_vector(vector: np.ndarray) -> np.ndarray:
    """Return the quaternion of a rotation vector ``(..., 3)`` (axis times angle in radians)."""
    vector = np.asarray(vector, float)
    half = np.linalg.norm(vector, axis=-1, keepdims=True) / 2
    # np.sinc keeps the limit at a zero angle exact
    return np.concatenate([np.cos(half), vector * (np.sinc(half / np.pi) / 2)], axis=-1)


def heading(quaternion: np.ndarray) -> np.ndarray:
    """Return the angle about y (radians) of each quaternion's twist part: the direction that a y-up body faces."""
    return 2 * np.arctan2(quaternion[..., 2], quaternion[..., 0])


def about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Return quaternions of rotations by ``angle`` radians about coordinate axis 0, 1 or 2."""
    vector = np.zeros((*np.shape(angle), 3))
    vector[..., axis] = angle
    return from_vector(vector)
