"""How a body bears itself in a motion, as a viewer reads mood from it: speed, height, openness and posture."""

from collections.abc import Sequence

import numpy as np

from ....motion import skeleton

_TORSO, _HEAD, _CLAVICLES = 0, 2, (3, 6)
_ELBOWS, _WRISTS = (5, 8), (6, 9)
"""Joints, left then right."""


def measure(directions: np.ndarray) -> dict[str, float]:
    """Return the means of a motion ``(frames, 9, 3)`` over its frames.

    ``speed``: of both wrists beside their shoulders, m/s; ``height``: of both wrists above the base of the spine, m;
    ``openness``: metres from left to right, mean of wrists and elbows (crossed arms count as negative); ``lean``: of the trunk
    forwards, degrees; ``chin``: how far the head is raised, degrees; ``shoulders``: how far they are raised, degrees.
    """
    steps = np.linalg.norm(np.diff(skeleton.wrists(directions), axis=0), axis=-1)
    speed = float(steps.mean() * skeleton.FPS) if len(steps) else 0.0
    return {"speed": speed, **{name: float(course.mean()) for name, course in courses(directions).items()}}


def courses(directions: np.ndarray) -> dict[str, np.ndarray]:
    """Return all figures of :func:`measure` but the speed at every frame ``(frames,)``."""
    motion = np.asarray(directions, float)
    joints = skeleton.to_positions(motion)
    apart = [joints[:, right, 0] - joints[:, left, 0] for left, right in (_ELBOWS, _WRISTS)]
    return {
        "height": -joints[:, _WRISTS, 1].mean(axis=1),
        "openness": np.mean(apart, axis=0),
        "lean": _tilt(motion[:, _TORSO]),
        "chin": -_tilt(motion[:, _HEAD]),
        "shoulders": np.degrees(np.arcsin(np.clip(-motion[:, _CLAVICLES, 1], -1, 1))).mean(axis=1),
    }


def mean(measured: Sequence[dict[str, float]]) -> dict[str, float]:
    """Return the mean of each figure of several motions."""
    return {name: float(np.mean([one[name] for one in measured])) for name in measured[0]}


def path_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return how alike both wrists' paths of two motions ``(frames, 9, 3)`` are at the same time.

    That is their correlation over all six coordinates, each about its own mean, as far as the shorter motion goes.
    """
    count = min(len(first), len(second))
    paths = [skeleton.wrists(one)[:count].reshape(count, -1) for one in (first, second)]
    a, b = (path - path.mean(axis=0) for path in paths)
    return float((a * b).sum() / max(np.sqrt((a * a).sum() * (b * b).sum()), 1e-12))


def _tilt(directions: np.ndarray) -> np.ndarray:
    """Return how far upward directions ``(frames, 3)`` are tilted forwards, degrees."""
    return np.degrees(np.arctan2(directions[:, 2], -directions[:, 1]))
