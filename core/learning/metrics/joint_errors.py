"""Errors of generated motion against recorded motion (reference section F.1).

Motions are directions ``(N, T, 9, 3)``; bones have the constant lengths of :mod:`skeleton`, so units are metres.
"""

import numpy as np

from ...motion import skeleton

MILLIMETRES = 1000.0


def positions(directions: np.ndarray, unit: bool = True) -> np.ndarray:
    """Return joint positions ``(..., 10, 3)``; ``unit`` normalises the directions.

    The public code does not normalise (reference section B.2), the paper does (eq. 11).
    """
    directions = np.asarray(directions, np.float64)
    if unit:
        return skeleton.to_positions(directions)
    steps = directions * skeleton.LENGTHS[:, None]
    joints = np.zeros((*steps.shape[:-2], len(skeleton.JOINTS), 3))
    for edge, (parent, child) in enumerate(skeleton.EDGES):
        joints[..., child, :] = joints[..., parent, :] + steps[..., edge, :]
    return joints


def maje_code(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> float:
    """Return the mean absolute joint error as defined by the public code, in millimetres.

    Mean of |x|, |y| and |z| over all ten joints, including the fixed root, after the ``seeds`` given frames; directions are
    not normalised.
    """
    return float(maje_code_windows(made, real, seeds).mean())


def maje_code_windows(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> np.ndarray:
    """Return :func:`maje_code` of every window ``(N,)``."""
    difference = positions(made, unit=False) - positions(real, unit=False)
    return np.abs(difference[:, seeds:]).mean((1, 2, 3)) * MILLIMETRES


def mpjpe(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> float:
    """Return the mean per-joint position error in millimetres of the nine moving joints, after the seeds; normalised."""
    return float(mpjpe_windows(made, real, seeds).mean())


def mpjpe_windows(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> np.ndarray:
    """Return :func:`mpjpe` of every window ``(N,)``."""
    difference = positions(made) - positions(real)
    return np.linalg.norm(difference[:, seeds:, 1:], axis=-1).mean((1, 2)) * MILLIMETRES


def mad_code(made: np.ndarray, real: np.ndarray) -> float:
    """Return the mean acceleration difference as defined by the public code, in millimetres per frame squared.

    Mean of |x|, |y| and |z| of the differences of second differences over all frames and ten joints; directions are not
    normalised. The paper prints this number as mm/s^2.
    """
    return float(mad_code_windows(made, real).mean())


def mad_code_windows(made: np.ndarray, real: np.ndarray) -> np.ndarray:
    """Return :func:`mad_code` of every window ``(N,)``."""
    difference = np.diff(positions(made, unit=False), n=2, axis=1) - np.diff(positions(real, unit=False), n=2, axis=1)
    return np.abs(difference).mean((1, 2, 3)) * MILLIMETRES


def mad_seconds(made: np.ndarray, real: np.ndarray, fps: float = skeleton.FPS) -> float:
    """Return :func:`mad_code` in the paper's unit, mm/s^2, by multiplying it with the squared frame rate."""
    return mad_code(made, real) * fps**2


def mad_norm(made: np.ndarray, real: np.ndarray, fps: float = skeleton.FPS) -> float:
    """Return the mean acceleration difference as the paper defines it: mean L2 norm of nine moving joints, in mm/s^2."""
    difference = np.diff(positions(made), n=2, axis=1) - np.diff(positions(real), n=2, axis=1)
    return float(np.linalg.norm(difference[:, :, 1:], axis=-1).mean() * MILLIMETRES * fps**2)
