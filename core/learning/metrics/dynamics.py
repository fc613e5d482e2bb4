"""Speed, acceleration and jerk as in the GENEA evaluations, and canonical correlation (reference section F.4)."""

import numpy as np

from ...motion import skeleton
from .joint_errors import MILLIMETRES, positions

WRISTS = (skeleton.JOINTS.index("left_wrist"), skeleton.JOINTS.index("right_wrist"))
CENTIMETRES = 100.0


def mean_derivative(directions: np.ndarray, order: int, fps: float = skeleton.FPS) -> float:
    """Return the mean norm of the ``order``-th derivative of the nine moving joints in mm/s^order (2 acceleration, 3 jerk)."""
    change = np.diff(positions(directions)[..., 1:, :], n=order, axis=1) * fps**order
    return float(np.linalg.norm(change, axis=-1).mean() * MILLIMETRES)


def wrist_speed_histogram(
    directions: np.ndarray, width: float = 1.0, top: float = 300.0, fps: float = skeleton.FPS
) -> np.ndarray:
    """Return the histogram ``(bins,)`` of both wrists' speeds in bins of ``width`` cm/s up to ``top``; the last is open."""
    joints = positions(directions)[..., WRISTS, :]
    speed = np.linalg.norm(np.diff(joints, axis=1), axis=-1).ravel() * fps * CENTIMETRES
    edges = np.arange(0, top + width / 2, width)
    counts, _ = np.histogram(np.minimum(speed, top - width / 2), edges)
    return counts / max(counts.sum(), 1)


def hellinger(a: np.ndarray, b: np.ndarray) -> float:
    """Return the Hellinger distance of two histograms with the same bins: 0 equal, 1 disjoint."""
    a, b = (np.asarray(part, np.float64) / max(np.sum(part), 1e-12) for part in (a, b))
    return float(np.sqrt(max(1 - np.sqrt(a * b).sum(), 0)))


def canonical_correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Return the first canonical correlation of ``a`` ``(n, p)`` and ``b`` ``(n, q)``; constant columns are ignored.

    It is the largest singular value between orthonormal bases of both. With few samples it is always near one: use many
    more rows than columns.
    """
    bases = []
    for part in (a, b):
        part = np.asarray(part, np.float64)
        left, values, _ = np.linalg.svd(part - part.mean(0), full_matrices=False)
        bases.append(left[:, values > 1e-8 * max(values[0], 1e-12) * len(part)] if values[0] > 0 else left[:, :0])
    if not (bases[0].shape[1] and bases[1].shape[1]):
        return 0.0
    return float(min(np.linalg.svd(bases[0].T @ bases[1], compute_uv=False)[0], 1.0))
