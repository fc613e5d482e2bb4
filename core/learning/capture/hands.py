"""Hands from the points of an estimator: knuckles, palms and fingers."""

import numpy as np

from ...motion import handshape, skeleton

WRIST, KNUCKLES = 0, (5, 9, 13, 17)
"""Points of a hand: the wrist and the first joints of the four fingers; three more follow each."""
THUMB = (1, 2, 3, 4)


def frame(points: np.ndarray, left: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return knuckle directions and palm normals ``(n, 3)`` of hands ``(n, 21, 3)`` in the canonical frame."""
    along = skeleton.normalize(points[:, KNUCKLES].mean(1) - points[:, WRIST])
    across = points[:, 5] - points[:, 17]
    normal = np.cross(along, across) if left else np.cross(across, along)
    return along, skeleton.normalize(normal)


def shape(points: np.ndarray, left: bool) -> np.ndarray:
    """Return handshapes ``(n, 12)`` in degrees (:data:`handshape.COLUMNS`) of hands ``(n, 21, 3)``."""
    along, palm = frame(points, left)
    columns = np.zeros((len(points), len(handshape.COLUMNS)))
    spread = []
    for number, base in enumerate(KNUCKLES):
        parts = np.stack([points[:, base] - points[:, WRIST], *np.diff(points[:, base : base + 4], axis=1).swapaxes(0, 1)], 1)
        parts = skeleton.normalize(parts)
        out = np.degrees(np.arcsin(np.clip(np.sum(parts[:, 1] * palm, -1), -1, 1)))
        columns[:, 2 * number] = np.where(np.sum(parts[:, 1] * parts[:, 0], -1) < 0, 180 - np.abs(out), out)
        columns[:, 2 * number + 1] = _between(parts[:, 1], parts[:, 2]) + _between(parts[:, 2], parts[:, 3])
        spread.append(skeleton.normalize(parts[:, 1] - palm * np.sum(parts[:, 1] * palm, -1, keepdims=True)))
    first, second, third = skeleton.normalize(np.diff(points[:, THUMB], axis=1)).swapaxes(0, 1)
    flat = skeleton.normalize(first - palm * np.sum(first * palm, -1, keepdims=True))
    columns[:, -4] = _between(flat, along)
    columns[:, -3] = np.degrees(np.arcsin(np.clip(np.sum(first * palm, -1), -1, 1)))
    columns[:, -2] = _between(first, second) + _between(second, third)
    columns[:, -1] = _between(spread[0], spread[3])
    return np.clip(columns, handshape.LOW, handshape.HIGH)


def _between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(np.sum(one * other, -1), -1, 1)))
