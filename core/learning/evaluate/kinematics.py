"""Speeds of motion: angular speed of edges, wrist velocity and jerk relative to the shoulders, frames with a gesture."""

import numpy as np

from ...motion import skeleton
from ...motion.skeleton import wrists

FOREARMS = (5, 8)
UPPER_ARMS = (4, 7)
MOVING_SPEED = 0.2
"""Metres a second: a wrist that is this fast within :data:`MOVING_REACH` seconds before or after is gesturing."""
MOVING_REACH = 0.33
"""Seconds."""


def angular_speed(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the angular speed ``(frames - 1, 9)`` in degrees a second of unit directions ``(frames, 9, 3)``."""
    # the chord is exact near zero, where an arc cosine is not
    chord = np.linalg.norm(np.diff(np.asarray(directions, float), axis=0), axis=-1)
    return np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))) * fps


def arm_speed(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the mean angular speed of upper arms and forearms ``(frames - 1,)`` in degrees a second: the motion energy."""
    return angular_speed(directions, fps)[:, skeleton.ARM_EDGES].mean(axis=1)


def wrist_distance_from_rest(directions: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return each wrist's distance ``(..., 2)`` in metres from its place in the resting pose ``(9, 3)``, from the shoulder."""
    return np.linalg.norm(wrists(directions) - wrists(rest), axis=-1)


def derivatives(points: np.ndarray, fps: float = skeleton.FPS) -> tuple[np.ndarray, np.ndarray]:
    """Return the magnitude of velocity (m/s) and jerk (m/s^3), both ``(frames - 3, ...)``, of points ``(frames, ..., 3)``."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=-1) * fps
    jerk = np.linalg.norm(np.diff(points, n=3, axis=0), axis=-1) * fps**3
    return (steps[:-2] + steps[1:-1] + steps[2:]) / 3, jerk


def gesturing(speed: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return whether each wrist is gesturing from its speed ``(frames, ...)`` in m/s: it is fast in or near the frame."""
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(speed, 2 * round(MOVING_REACH * fps) + 1, axis=0) > MOVING_SPEED
