"""Which windows are worth learning from: the TED loader's tests (reference section B.5). numpy alone."""

import numpy as np

from ...motion import skeleton

LEAST_WORDS = 2
AVERAGE = 0.02
"""Mean distance by coordinate from the mean pose below which a window shows nothing but it."""
SPINE_MOST, SPINE_MEAN = 30.0, 20.0
"""Degrees that the torso may lean."""
WRIST_VARIANCE = 0.0014
"""Square metres, summed over x, y and z; a window in which both wrists stay below it holds no gesture."""
_WRISTS = [skeleton.JOINTS.index("left_wrist"), skeleton.JOINTS.index("right_wrist")]


def usable(directions: np.ndarray, words: np.ndarray) -> np.ndarray:
    """``(n,)`` bool: windows ``(n, T, 9, 3)`` with two words ``(n,)`` that are upright, move and are not the mean pose.

    Positions are rebuilt with constant bone lengths, while the loader tests the data's own coordinates, which are smaller.
    """
    directions = skeleton.normalize(np.asarray(directions, np.float32))
    joints = skeleton.to_positions(directions)
    average = np.abs(joints - skeleton.to_positions(skeleton.MEAN_UNIT)).mean((1, 2, 3)) < AVERAGE
    lean = np.degrees(np.arccos(np.clip(-directions[:, :, 0, 1], -1, 1)))
    leaning = (lean.max(1) > SPINE_MOST) | (lean.mean(1) > SPINE_MEAN)
    still = (joints[:, :, _WRISTS].var(1).sum(-1) < WRIST_VARIANCE).all(1)
    return (np.asarray(words) >= LEAST_WORDS) & ~average & ~leaning & ~still
