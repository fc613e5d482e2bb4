"""Quaternions and turns of directions, as few as the corpus needs. Quaternions are ``(..., 4)``, w first, unit length."""

import numpy as np

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def from_vector(vector: np.ndarray) -> np.ndarray:
    """Quaternion of a rotation vector ``(..., 3)`` (axis times angle in radians)."""
    vector = np.asarray(vector, float)
    half = np.linalg.norm(vector, axis=-1, keepdims=True) / 2
    # np.sinc keeps the limit at a zero angle exact
    return np.concatenate([np.cos(half), vector * (np.sinc(half / np.pi) / 2)], axis=-1)


def multiply(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Hamilton product: first ``right``, then ``left``."""
    scalar = left[..., :1] * right[..., :1] - np.sum(left[..., 1:] * right[..., 1:], axis=-1, keepdims=True)
    vector = left[..., :1] * right[..., 1:] + right[..., :1] * left[..., 1:] + np.cross(left[..., 1:], right[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def conjugate(quaternion: np.ndarray) -> np.ndarray:
    """The inverse rotation."""
    return quaternion * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors ``(..., 3)`` turned by the quaternions."""
    axis = quaternion[..., 1:]
    twice = 2 * np.cross(axis, vector)
    return vector + quaternion[..., :1] * twice + np.cross(axis, twice)


def heading(quaternion: np.ndarray) -> np.ndarray:
    """Angle about y (radians) of the twist part of each quaternion: where a y-up body faces."""
    return 2 * np.arctan2(quaternion[..., 2], quaternion[..., 0])


def about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Quaternions that turn by ``angle`` radians about coordinate axis 0, 1 or 2."""
    vector = np.zeros((*np.shape(angle), 3))
    vector[..., axis] = angle
    return from_vector(vector)


def slerp(start: np.ndarray, end: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Directions between ``start`` and ``end`` ``(..., 3)`` along the great circle.

    ``weight`` broadcasts against the leading axes; outside 0..1 it goes on along the same circle. Opposite directions
    have no shortest way, so they are turned through whatever axis rounding leaves.
    """
    weight = np.asarray(weight, float)[..., None]
    cosine = np.clip(np.sum(start * end, axis=-1, keepdims=True), -1, 1)
    angle = np.arccos(cosine)
    across = end - cosine * start
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.divide(across, length, out=np.zeros_like(across), where=length > 1e-9)
    return start * np.cos(weight * angle) + across * np.sin(weight * angle)
