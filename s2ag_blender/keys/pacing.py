"""Adjusts the speed of strokes and the smoothness of a motion, in sync with the voice."""

import numpy as np

from ...core.motion import quaternion, skeleton
from ...core.motion.motion import Motion
from ...core.smoothing import gaussian

APART = 0.16
"""Least seconds between two turning points."""


def change_speed(motion: Motion, speed: float) -> Motion:
    """Return the motion with strokes ``speed`` times as fast half-way, and slower where they turn.

    The turning points of the hands, which are in sync with the words, keep their times."""
    if speed == 1.0 or len(motion.directions) < 4:
        return motion
    turns = np.concatenate([[0], _turning_points(motion), [len(motion.directions) - 1]])
    row = np.arange(len(motion.directions))
    span = np.clip(np.searchsorted(turns, row, side="right") - 1, 0, len(turns) - 2)
    length = turns[span + 1] - turns[span]
    share = (row - turns[span]) / length
    eased = share**speed / (share**speed + (1.0 - share) ** speed)
    return motion.at(turns[span] + eased * length, motion.fps)


def smooth_rotations(rotations: dict[str, np.ndarray], fps: float, seconds: float) -> dict[str, np.ndarray]:
    """Smooth rotations ``{bone: (keys, 4)}`` at ``fps`` keys per second over about ``seconds`` with a Gaussian."""
    if seconds <= 0:
        return rotations
    sigma = 0.5 * seconds * fps
    result = {}
    for bone, values in rotations.items():
        if len(values) > 1 and sigma > 0.1:
            values = quaternion.continuous(values)
            values = np.stack([gaussian(column, sigma) for column in values.T], -1)
            values = values / np.linalg.norm(values, axis=-1, keepdims=True)
        result[bone] = values
    return result


def _turning_points(motion: Motion) -> np.ndarray:
    """Return the inner frames at which the arms together are slowest, :data:`APART` seconds or more apart."""
    arms = motion.directions[:, list(skeleton.ARM_EDGES)].astype(float)
    speed = gaussian(np.linalg.norm(np.gradient(arms, axis=0), axis=(1, 2)), 1.0)
    lows = np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:])) + 1
    kept: list[int] = []
    for row in sorted(lows, key=lambda row: speed[row]):
        if all(abs(row - neighbour) >= APART * motion.fps for neighbour in (0, len(speed) - 1, *kept)):
            kept.append(int(row))
    return np.array(sorted(kept), int)
