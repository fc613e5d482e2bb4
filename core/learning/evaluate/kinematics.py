"""How fast things move: angular speeds of directions, wrists seen from the shoulders, frames in which a hand gestures."""

import numpy as np

from ...motion import skeleton
from ...motion.skeleton import wrists

FOREARMS = (5, 8)
UPPER_ARMS = (4, 7)
MOVING_SPEED = 0.2
"""Metres a second: a wrist that is this fast within :data:`MOVING_REACH` seconds before or after takes part in a gesture."""
MOVING_REACH = 0.33


def angular_speed(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Degrees a second ``(frames - 1, 9)`` of every edge of unit directions ``(frames, 9, 3)``."""
    # the chord is exact near zero, where an arc cosine is not
    chord = np.linalg.norm(np.diff(np.asarray(directions, float), axis=0), axis=-1)
    return np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))) * fps


def arm_speed(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Mean angular speed of both upper arms and forearms ``(frames - 1,)`` in degrees a second: the motion energy."""
    return angular_speed(directions, fps)[:, skeleton.ARM_EDGES].mean(axis=1)


def away(directions: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Metres ``(..., 2)`` of each wrist from where it is in the resting pose ``(9, 3)``, seen from the shoulder."""
    return np.linalg.norm(wrists(directions) - wrists(rest), axis=-1)


def derivatives(points: np.ndarray, fps: float = skeleton.FPS) -> tuple[np.ndarray, np.ndarray]:
    """Size of velocity (m/s) and of jerk (m/s^3), both ``(frames - 3, ...)``, of points ``(frames, ..., 3)``."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=-1) * fps
    jerk = np.linalg.norm(np.diff(points, n=3, axis=0), axis=-1) * fps**3
    return (steps[:-2] + steps[1:-1] + steps[2:]) / 3, jerk


def moving(speed: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Whether each wrist takes part in a gesture, from its speed ``(frames, ...)`` in m/s: fast now or nearly now."""
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(speed, 2 * round(MOVING_REACH * fps) + 1, axis=0) > MOVING_SPEED
