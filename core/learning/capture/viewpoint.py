"""Where the camera stands, by how body and face look: estimated points alone turn a body that is seen from aside too little,
and lean it back. A linear map that films from known cameras taught; :mod:`lifting_training` learns it. Needs numpy alone."""

import numpy as np

from .landmarks import Landmarks

TO_CANONICAL = np.array([-1.0, 1.0, -1.0])
"""From the estimator's axes (right in the picture, down, away from the camera) to the canonical ones."""
SHOULDERS, HIPS = (11, 12), (23, 24)
_POINTS = (0, 3, 6, 7, 8, 9, 10, 11, 12, 23, 24, 25, 26, 13, 14)
_MIRRORED = (0, 2, 1, 4, 3, 6, 5, 8, 7, 10, 9, 12, 11, 14, 13)
_FACE_MIRRORED = (0, 1, 3, 2, 4, 6, 5, 7, 8, 10, 9)
MIRROR = np.array([-1.0, 1.0, 1.0])
_RIDGE = 0.1
"""Share of the variance of a feature that is added to it."""


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
    return np.concatenate([*(part.reshape(len(there), -1) for part in parts), there[:, None], np.ones((len(there), 1))], 1)


def learn(seen: list[np.ndarray], known: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the map from features ``(n, d)`` of films to the ``known`` angles ``(n, 2)``."""
    rows, wanted = np.concatenate(seen), np.concatenate(known)
    mean, size = rows.mean(0), rows.std(0) + 1e-2
    mean[-1], size[-1] = 0, 1
    scaled = (rows - mean) / size
    stiff = _RIDGE * len(rows) * np.eye(len(mean))
    stiff[-1, -1] = 0
    return {"mean": mean, "size": size, "map": np.linalg.solve(scaled.T @ scaled + stiff, scaled.T @ wanted)}


def _mapped(rows: np.ndarray, weights: dict[str, np.ndarray]) -> np.ndarray:
    return (rows - weights["mean"]) / weights["size"] @ weights["map"]
