"""Unit quaternions as arrays ``(..., 4)`` in the order w, x, y, z; vectors are ``(..., 3)``, angles radians.

All functions broadcast over leading axes. In functions that ensure continuity, the first axis is time."""

import numpy as np

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
EULER_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
_TINY = 1e-12


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product of vectors; for short arrays several times faster than numpy's, with equal results."""
    b = np.asarray(b)
    components = [a[..., i] * b[..., j] - a[..., j] * b[..., i] for i, j in ((1, 2), (2, 0), (0, 1))]
    return np.stack(components, -1)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product: the rotation ``b`` followed by ``a``."""
    a, b = np.asarray(a), np.asarray(b)
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], -1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], -1)


def conjugate(q: np.ndarray) -> np.ndarray:
    """Return the inverse rotation."""
    return np.asarray(q) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rotate the vectors ``v`` by ``q``."""
    q = np.asarray(q)
    twice = 2.0 * cross(q[..., 1:], v)
    return v + q[..., :1] * twice + cross(q[..., 1:], twice)


def about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the rotation by ``angle`` ``(...)`` about the unit vectors ``axis`` ``(..., 3)``."""
    half = 0.5 * np.asarray(angle, float)[..., None]
    cosine, vector = np.cos(half), np.sin(half) * axis
    return np.concatenate([np.broadcast_to(cosine, (*vector.shape[:-1], 1)), vector], -1)


def swing(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the shortest rotation that maps unit vectors ``start`` onto ``end``; half a turn if they are opposite."""
    start, end = np.broadcast_arrays(np.asarray(start, float), np.asarray(end, float))
    q = np.concatenate([1.0 + np.sum(start * end, -1, keepdims=True), cross(start, end)], -1)
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    half_turn = np.concatenate([np.zeros_like(length), perpendicular(start)], -1)
    return np.where(length > 1e-7, q / np.maximum(length, _TINY), half_turn)


def perpendicular(v: np.ndarray) -> np.ndarray:
    """Return a unit vector at right angles to each unit vector ``v``."""
    axis = np.eye(3)[np.argmin(np.abs(v), -1)]
    side = np.cross(v, axis)
    return side / np.linalg.norm(side, axis=-1, keepdims=True)


def power(q: np.ndarray, exponent: float | np.ndarray, short: bool = True) -> np.ndarray:
    """Return the fraction ``exponent`` of the rotation ``q``, the short way round, or with ``short`` False as its sign says."""
    q = np.asarray(q)
    q = np.where(short & (q[..., :1] < 0), -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1)
    axis = q[..., 1:] / np.maximum(sine, _TINY)[..., None]
    return about(axis, 2.0 * np.arctan2(sine, q[..., 0]) * exponent)


def slerp(a: np.ndarray, b: np.ndarray, t: float | np.ndarray) -> np.ndarray:
    """Interpolate spherically from ``a`` (t = 0) to ``b`` (t = 1)."""
    return multiply(a, power(multiply(conjugate(a), b), t))


def continuous(q: np.ndarray) -> np.ndarray:
    """Choose the signs of quaternions ``(frames, ..., 4)`` so that successive ones are near; the first has w >= 0."""
    q = np.array(q, float)
    flips = np.sign(np.sum(q[1:] * q[:-1], -1, keepdims=True))
    first = np.where(q[:1, ..., :1] < 0, -1.0, 1.0)
    return q * np.cumprod(np.concatenate([first, np.where(flips == 0, 1.0, flips)]), 0)


def to_matrix(q: np.ndarray) -> np.ndarray:
    """Return rotation matrices ``(..., 3, 3)`` for column vectors."""
    return np.stack([rotate(q, axis) for axis in np.eye(3)], -1)


def from_matrix(matrix: np.ndarray) -> np.ndarray:
    """Convert rotation matrices ``(..., 3, 3)``; uses the largest diagonal term of q q^T, so it is never ill-conditioned."""
    m = np.asarray(matrix, float)
    trace = np.trace(m, axis1=-2, axis2=-1)
    outer = np.empty((*m.shape[:-2], 4, 4))  # 4 q q^T
    outer[..., 0, 0] = 1.0 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i + 1, i + 1] = 1.0 - trace + 2.0 * m[..., i, i]
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = m[..., k, j] - m[..., j, k]
        outer[..., j + 1, k + 1] = outer[..., k + 1, j + 1] = m[..., j, k] + m[..., k, j]
    best = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), -1)
    q = np.take_along_axis(outer, best[..., None, None], -2)[..., 0, :]
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def from_euler(angles: np.ndarray, order: str = "XYZ") -> np.ndarray:
    """Convert Euler angles ``(..., 3)`` given as x, y, z; in ``order`` XYZ the x rotation is applied first, as in Blender."""
    angles = np.asarray(angles, float)
    first, second, third = (about(np.eye(3)["XYZ".index(axis)], angles[..., "XYZ".index(axis)]) for axis in order)
    return multiply(third, multiply(second, first))


def to_euler(q: np.ndarray, order: str = "XYZ") -> np.ndarray:
    """Convert rotations ``(frames, 4)`` to Euler angles ``(frames, 3)`` as x, y, z, without jumps over time.

    Each rotation has two sets of angles. At each frame, the set nearer to the one before is chosen; because distances
    between first sets and between second sets are equal, the choice is a running parity and needs no loop."""
    i, j, k = ("XYZ".index(axis) for axis in order)
    odd = 1.0 if (j - i) % 3 == 1 else -1.0
    m = to_matrix(np.asarray(q, float))
    cosine = np.hypot(m[:, i, i], m[:, j, i])
    angles = np.empty((len(m), 3))
    angles[:, i] = np.arctan2(odd * m[:, k, j], m[:, k, k])
    angles[:, j] = np.arctan2(-odd * m[:, k, i], cosine)
    angles[:, k] = np.arctan2(odd * m[:, j, i], m[:, i, i])
    _resolve_locked(angles, m, cosine, (i, j, k), odd)
    other = angles + np.pi
    other[:, j] = np.pi - angles[:, j]
    stay = _turn_distance(angles[1:], angles[:-1])
    change = _turn_distance(other[1:], angles[:-1])
    wrapped_other = np.mod(other[:1] + np.pi, 2 * np.pi) - np.pi
    start = np.abs(wrapped_other).sum() < np.abs(angles[:1]).sum() - 1e-9
    parity = np.cumsum(np.concatenate([[start], change < stay - 1e-9])) % 2
    chosen = np.where(parity[:, None] == 1, other, angles)
    chosen[0] = np.mod(chosen[0] + np.pi, 2 * np.pi) - np.pi
    return np.unwrap(chosen, axis=0)


def _resolve_locked(angles: np.ndarray, m: np.ndarray, cosine: np.ndarray, axes: tuple[int, int, int], odd: float) -> None:
    """Fill in angles of frames in gimbal lock, where only the sum of the outer ones is defined: keep the last from before."""
    i, j, k = axes
    locked = cosine < 1e-7
    if not locked.any():
        return
    frames = np.arange(len(m))
    held = np.maximum.accumulate(np.where(locked, -1, frames))
    angles[locked, k] = np.where(held[locked] >= 0, angles[np.maximum(held[locked], 0), k], 0.0)
    sine = np.where(angles[locked, j] > 0, 1.0, -1.0)
    total = np.arctan2(-odd * m[locked, j, k], m[locked, j, j])
    angles[locked, i] = total + sine * angles[locked, k]


def _turn_distance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the sum of the angles' distances, modulo whole turns."""
    return np.abs(np.mod(a - b + np.pi, 2 * np.pi) - np.pi).sum(-1)


def to_axis_angle(q: np.ndarray) -> np.ndarray:
    """Convert rotations ``(frames, 4)`` to angle and axis ``(frames, 4)``, without jumps over time; angles may be negative."""
    q = continuous(q)
    sine = np.linalg.norm(q[:, 1:], axis=-1)
    defined = sine > 1e-9
    axis = q[:, 1:] / np.maximum(sine, _TINY)[:, None]
    if not defined.any():
        return np.concatenate([np.zeros((len(q), 1)), np.tile([0.0, 1.0, 0.0], (len(q), 1))], -1)
    nearest = np.maximum.accumulate(np.where(defined, np.arange(len(q)), -1))
    nearest[nearest < 0] = np.argmax(defined)
    axis = axis[nearest]
    flips = np.where(np.sum(axis[1:] * axis[:-1], -1) < 0, -1.0, 1.0)
    sign = np.cumprod(np.concatenate([[1.0], flips]))
    angle = 2.0 * np.arctan2(sign * sine * defined, q[:, 0])
    return np.concatenate([np.unwrap(angle, period=4 * np.pi)[:, None], axis * sign[:, None]], -1)
