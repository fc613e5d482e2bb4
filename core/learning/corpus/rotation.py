"""Rotations for the corpus, beside those of :mod:`s2ag.core.motion.quaternion`; quaternions ``(..., 4)``, w first, unit."""

import numpy as np

from ...motion.quaternion import IDENTITY, conjugate, multiply, rotate

__all__ = ["IDENTITY", "about", "conjugate", "from_vector", "heading", "multiply", "rotate"]


def from_vector(vector: np.ndarray) -> np.ndarray:
    """Quaternion of a rotation vector ``(..., 3)`` (axis times angle in radians)."""
    vector = np.asarray(vector, float)
    half = np.linalg.norm(vector, axis=-1, keepdims=True) / 2
    # np.sinc keeps the limit at a zero angle exact
    return np.concatenate([np.cos(half), vector * (np.sinc(half / np.pi) / 2)], axis=-1)


def heading(quaternion: np.ndarray) -> np.ndarray:
    """Angle about y (radians) of the twist part of each quaternion: where a y-up body faces."""
    return 2 * np.arctan2(quaternion[..., 2], quaternion[..., 0])


def about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Quaternions that turn by ``angle`` radians about coordinate axis 0, 1 or 2."""
    vector = np.zeros((*np.shape(angle), 3))
    vector[..., axis] = angle
    return from_vector(vector)
