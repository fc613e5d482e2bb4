"""How far generated motion lies from the performed one (reference section F.1).

Motions are directions ``(N, T, 9, 3)``, skeletons have the constant lengths of :mod:`skeleton`, so one unit is a metre.
"""

import numpy as np

from ...motion import skeleton

MILLIMETRES = 1000.0


def positions(directions: np.ndarray, unit: bool = True) -> np.ndarray:
    """Joints ``(..., 10, 3)``; with ``unit`` every bone has its length, without it the vectors stay as long as they came.

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
    """Mean absolute joint error as the public code has it, in millimetres.

    Mean of |x|, |y| and |z| over all ten joints, the fixed root included, after the ``seeds`` given frames; vectors not
    normalised.
    """
    return float(maje_code_windows(made, real, seeds).mean())


def maje_code_windows(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> np.ndarray:
    """:func:`maje_code` of every window ``(N,)``."""
    apart = positions(made, unit=False) - positions(real, unit=False)
    return np.abs(apart[:, seeds:]).mean((1, 2, 3)) * MILLIMETRES


def mpjpe(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> float:
    """Mean distance in millimetres of the nine joints that can move, after the seeds, bones at their lengths."""
    return float(mpjpe_windows(made, real, seeds).mean())


def mpjpe_windows(made: np.ndarray, real: np.ndarray, seeds: int = 4) -> np.ndarray:
    """:func:`mpjpe` of every window ``(N,)``."""
    apart = positions(made) - positions(real)
    return np.linalg.norm(apart[:, seeds:, 1:], axis=-1).mean((1, 2)) * MILLIMETRES


def mad_code(made: np.ndarray, real: np.ndarray) -> float:
    """Mean acceleration difference as the public code has it, in millimetres per frame squared.

    Mean of |x|, |y| and |z| of the differences of second differences over all frames and ten joints, vectors not
    normalised. The paper prints this number under mm/s^2.
    """
    return float(mad_code_windows(made, real).mean())


def mad_code_windows(made: np.ndarray, real: np.ndarray) -> np.ndarray:
    """:func:`mad_code` of every window ``(N,)``."""
    apart = np.diff(positions(made, unit=False), n=2, axis=1) - np.diff(positions(real, unit=False), n=2, axis=1)
    return np.abs(apart).mean((1, 2, 3)) * MILLIMETRES


def mad_seconds(made: np.ndarray, real: np.ndarray, fps: float = skeleton.FPS) -> float:
    """:func:`mad_code` in the unit that the paper names, mm/s^2: the frame rate squared times as much."""
    return mad_code(made, real) * fps**2


def mad_norm(made: np.ndarray, real: np.ndarray, fps: float = skeleton.FPS) -> float:
    """Mean acceleration difference as the paper words it: mean L2 norm over the nine moving joints, in mm/s^2."""
    apart = np.diff(positions(made), n=2, axis=1) - np.diff(positions(real), n=2, axis=1)
    return float(np.linalg.norm(apart[:, :, 1:], axis=-1).mean() * MILLIMETRES * fps**2)
