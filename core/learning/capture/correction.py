"""What the estimator always gets wrong, learned on films of known motions: two linear maps, for arms and for hands.

Single pictures tell little about depth: estimated elbows lie too far ahead, palms lean towards the camera. ``s2ag evaluate
--capture --choosing`` fits the maps (ridge regression; right and left are one, mirrored) and writes ``correction.json``.
"""

import json
from functools import cache
from pathlib import Path

import numpy as np

from ...motion import skeleton

FILE = Path(__file__).with_name("correction.json")
MIRROR = np.array([-1.0, 1.0, 1.0])
_RIDGE = {"arm": 0.2, "hand": 0.05}
"""Share of the variance of a feature that is added to it."""
_POINTS = (4, 5, 8, 9, 17, 20)
"""Points of a hand that are features: tips of thumb, index and little finger, knuckles."""


def arm_features(points: np.ndarray, picture: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return features ``(n, 13)`` of arms: shoulder, elbow and wrist ``(n, 3, 3)`` in body axes, in metres of the picture
    ``(n, 3, 2)``, and the view ``(n, 3, 3)``; of right arms, or mirrored.
    """
    bones = skeleton.normalize(np.diff(points, axis=1)).reshape(len(points), 6)
    flat = np.diff(picture, axis=1).reshape(len(points), 4)
    return np.concatenate([np.ones((len(points), 1)), bones, view[:, [0, 1], 2], flat], 1)


def hand_features(points: np.ndarray, along: np.ndarray, palm: np.ndarray, forearm: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return features ``(n, 30)`` of hands ``(n, 21, 3)`` with their estimated directions; of right hands, or mirrored."""
    middle = points.mean(1, keepdims=True)
    size = np.maximum(np.linalg.norm(points - middle, axis=-1).max(1), 1e-9)[:, None, None]
    flat = ((points[:, _POINTS] - points[:, :1]) / size).reshape(len(points), -1)
    return np.concatenate([np.ones((len(points), 1)), along, palm, view[:, [0, 1], 2], forearm, flat], 1)


def mirrored_view(view: np.ndarray) -> np.ndarray:
    """Return the views ``(n, 3, 3)`` of mirrored pictures."""
    return view * MIRROR[:, None] * MIRROR


def fit(kind: str, features: np.ndarray, wanted: np.ndarray) -> dict:
    """Return the map from ``features`` ``(n, d)`` to what is ``wanted`` ``(n, 6)`` as JSON."""
    mean, size = features.mean(0), features.std(0) + 1e-6
    mean[0], size[0] = 0.0, 1.0
    scaled = (features - mean) / size
    ridge = np.eye(len(mean)) * _RIDGE[kind] * len(scaled)
    ridge[0, 0] = 0
    weights = np.linalg.solve(scaled.T @ scaled + ridge, scaled.T @ wanted)
    return {"mean": mean.round(5).tolist(), "size": size.round(5).tolist(), "weights": weights.round(5).tolist()}


def apply(kind: str, features: np.ndarray) -> np.ndarray:
    """Return what is to be added to an arm's two directions, or a hand's along and palm themselves, ``(n, 2, 3)``."""
    chosen = _maps().get(kind)
    if chosen is None:
        return np.zeros((len(features), 2, 3))
    mean, size, weights = (np.array(chosen[name]) for name in ("mean", "size", "weights"))
    return ((features - mean) / size @ weights).reshape(-1, 2, 3)


@cache
def _maps() -> dict:
    return json.loads(FILE.read_text("utf-8")) if FILE.is_file() else {}


def forget() -> None:
    """Read the maps anew."""
    _maps.cache_clear()
