"""Where the camera stands, by how body, arms and face look: estimated points alone turn a body that is seen from aside too
little, and lean it back. Small networks that films from known cameras taught; :mod:`viewpoint_training` learns them. Needs
numpy alone."""

import numpy as np

from .landmarks import Landmarks

TO_CANONICAL = np.array([-1.0, 1.0, -1.0])
"""From the estimator's axes (right in the picture, down, away from the camera) to the canonical ones."""
SHOULDERS, HIPS = (11, 12), (23, 24)
_POINTS = (0, 3, 6, 7, 8, 9, 10, *range(11, 27))
_MIRRORED = (0, 2, 1, 4, 3, 6, 5, *(at + 1 - 2 * (at % 2 == 0) for at in range(7, 23)))
_FACE_MIRRORED = (0, 1, 3, 2, 4, 6, 5, 7, 8, 10, 9)
MIRROR = np.array([-1.0, 1.0, 1.0])
UNIT = 20.0
"""Degrees that the networks count as one."""
FAR = 4.0
"""Deviations beyond which a feature counts no further."""


def angles(found: Landmarks, weights: dict[str, np.ndarray]) -> np.ndarray:
    """Return degrees ``(n, 2)`` that the camera stands to the left of where the body looks, and above it, for each picture."""
    one, other = (_mapped(part, weights) for part in features(found))
    return (one + other * [-1, 1]) / 2


def view(angles: np.ndarray) -> np.ndarray:
    """Return rotations ``(n, 3, 3)`` from the axes of cameras at ``angles`` ``(n, 2)`` in degrees to those of the body."""
    (turn, tilt), zero = np.radians(angles).T, np.zeros(len(angles))
    across = np.stack([np.cos(turn), zero, np.sin(turn)], -1)
    ahead = np.stack([-np.sin(turn) * np.cos(tilt), -np.sin(tilt), np.cos(turn) * np.cos(tilt)], -1)
    return np.stack([across, np.cross(ahead, across), ahead], -1)


def features(found: Landmarks) -> tuple[np.ndarray, np.ndarray]:
    """Return the features ``(n, d)`` of pictures, and of the same pictures mirrored."""
    width, height = found.size
    deep = np.nan_to_num(found.world * TO_CANONICAL)
    flat = np.nan_to_num(found.pose[..., :2]) * [-width, height]
    middle = flat[:, SHOULDERS].mean(1, keepdims=True)
    tall = np.linalg.norm(middle - flat[:, HIPS].mean(1, keepdims=True), axis=-1, keepdims=True)
    deep = (deep - deep[:, SHOULDERS].mean(1, keepdims=True))[:, _POINTS]
    flat = ((flat - middle) / np.maximum(tall, 1e-6))[:, _POINTS]
    face = found.face * TO_CANONICAL * [width, height, width]
    there = np.isfinite(face).all((1, 2))
    face = np.nan_to_num(face) - np.nan_to_num(face).mean(1, keepdims=True)
    face = face / np.maximum(np.linalg.norm(face, axis=-1).mean(1), 1e-6)[:, None, None] * there[:, None, None]
    mirrored = deep[:, _MIRRORED] * MIRROR, flat[:, _MIRRORED] * MIRROR[:2], face[:, _FACE_MIRRORED] * MIRROR
    return _joined((deep, flat, face), there), _joined(mirrored, there)


def _joined(parts: tuple[np.ndarray, ...], there: np.ndarray) -> np.ndarray:
    return np.concatenate([*(part.reshape(len(there), -1) for part in parts), there[:, None]], 1)


def _mapped(rows: np.ndarray, weights: dict[str, np.ndarray]) -> np.ndarray:
    scaled = np.clip((rows - weights["mean"]) / weights["size"], -FAR, FAR)
    made = np.zeros((len(rows), 2))
    for number in range(int(weights["networks"])):
        hidden = scaled
        for layer in ("first", "second"):
            hidden = np.maximum(hidden @ weights[f"{number}.{layer}"] + weights[f"{number}.{layer}_bias"], 0)
        made += hidden @ weights[f"{number}.last"] + weights[f"{number}.last_bias"]
    return made / int(weights["networks"]) * UNIT
