"""Rotations of torso and head away from the data's mean pose, computed from edge directions."""

import numpy as np

from ..core.motion import quaternion, skeleton
from ..core.motion.interpolation import smoothstep
from . import arms

NEUTRAL = skeleton.normalize(skeleton.MEAN_UNIT + skeleton.mirror(skeleton.MEAN_UNIT))
"""The data's mean pose (9, 3), made symmetric so that a mirrored motion gives a mirrored pose."""


def turn(primary: np.ndarray, secondary: np.ndarray, to_primary: np.ndarray, to_secondary: np.ndarray) -> np.ndarray:
    """Return the rotation that maps unit ``primary`` onto ``to_primary`` and ``secondary`` as near as possible to its target.

    All are ``(..., 3)``. The turn about ``to_primary`` fades out where a secondary vector is nearly parallel to its primary."""
    lean = quaternion.swing(primary, to_primary)
    carried = quaternion.rotate(lean, secondary)
    size = np.minimum(
        np.linalg.norm(np.cross(to_primary, carried), axis=-1), np.linalg.norm(np.cross(to_primary, to_secondary), axis=-1)
    )
    angle = arms.angle_about(to_primary, carried, to_secondary) * smoothstep(size, 0.05, 0.3)
    return quaternion.multiply(quaternion.about(to_primary, angle), lean)


def torso_turn(directions: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return the torso's rotation (frames, 4) from the mean pose: lean from the spine, twist from the line of the shoulders."""

    def line(pose: np.ndarray) -> np.ndarray:
        return skeleton.normalize(pose[..., 3, :] - pose[..., 6, :])

    return turn(mean[0], line(mean), directions[:, 0], line(directions))


def head_turn(directions: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return the head's rotation (frames, 4) from the mean pose.

    The edges neck to nose and nose to crown lie in the head's plane of symmetry: their sum points up, their difference, at
    right angles to it, to the front. One edge alone could not distinguish turning from tilting."""

    def up(pose: np.ndarray) -> np.ndarray:
        return skeleton.normalize(pose[..., 1, :] + pose[..., 2, :])

    def front(pose: np.ndarray) -> np.ndarray:
        return pose[..., 1, :] - pose[..., 2, :]

    return turn(up(mean), front(mean), up(directions), front(directions))
