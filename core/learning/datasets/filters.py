"""Selects windows to learn from, by the tests of the TED loader (reference section B.5). Needs numpy alone."""

import numpy as np

from ...motion import skeleton

LEAST_WORDS = 2
AVERAGE = 0.02
"""Mean absolute distance by coordinate from the mean pose in metres, below which a window counts as the mean pose."""
SPINE_MOST, SPINE_MEAN = 30.0, 20.0
"""Largest lean of the torso in degrees: in any frame, and on average."""
WRIST_VARIANCE = 0.0014
"""Variance of a wrist's position in square metres, summed over x, y and z; with both wrists below it, there is no gesture."""
_WRISTS = [skeleton.JOINTS.index("left_wrist"), skeleton.JOINTS.index("right_wrist")]


def usable(directions: np.ndarray, words: np.ndarray) -> np.ndarray:
    """Return which windows ``(n, T, 9, 3)`` are upright, move, differ from the mean pose and have two ``words`` ``(n,)``.

    Positions are computed with constant bone lengths, while the loader tests the data's own coordinates, which are smaller.
    """
    directions = skeleton.normalize(np.asarray(directions, np.float32))
    joints = skeleton.to_positions(directions)
    average = np.abs(joints - skeleton.to_positions(skeleton.MEAN_UNIT)).mean((1, 2, 3)) < AVERAGE
    lean = np.degrees(np.arccos(np.clip(-directions[:, :, 0, 1], -1, 1)))
    leaning = (lean.max(1) > SPINE_MOST) | (lean.mean(1) > SPINE_MEAN)
    still = (joints[:, :, _WRISTS].var(1).sum(-1) < WRIST_VARIANCE).all(1)
    return (np.asarray(words) >= LEAST_WORDS) & ~average & ~leaning & ~still
