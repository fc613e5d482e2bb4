"""Frechet distance between two sets of features (reference section F.2)."""

import numpy as np

from ...errors import UsageError


def frechet_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Return the Frechet distance of normal distributions fitted to features ``a`` ``(n, d)`` and ``b`` ``(m, d)``.

    ``|m1 - m2|^2 + tr(S1 + S2 - 2 sqrt(S1 S2))`` with unbiased covariances. The trace of the root is computed from the
    eigenvalues of a symmetric matrix, so it is always real. Raises :class:`UsageError` for fewer than two samples or for
    values that are not finite.
    """
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if min(len(a), len(b)) < 2:
        raise UsageError("A Frechet distance needs two samples of each set.", "Evaluate more windows.")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise UsageError("Features hold values that are not finite.", "Train the network or the extractor again.")
    cov_a, cov_b = (np.atleast_2d(np.cov(part, rowvar=False)) for part in (a, b))
    return float(distance_of_moments(a.mean(0), cov_a, b.mean(0), cov_b, matrix_root(cov_b)))


def distance_of_moments(
    mean_a: np.ndarray, cov_a: np.ndarray, mean_b: np.ndarray, cov_b: np.ndarray, root_b: np.ndarray
) -> np.ndarray:
    """Return the :func:`frechet_distance` ``(...)`` of normal distributions: means ``(..., d)``, covariances ``(..., d, d)``.

    ``root_b`` is the :func:`matrix_root` of ``cov_b``, computed once for many distances.
    """
    shared = np.linalg.eigvalsh(root_b @ cov_a @ root_b)
    traces = np.trace(cov_a, axis1=-2, axis2=-1) + np.trace(cov_b, axis1=-2, axis2=-1)
    distance = np.square(mean_a - mean_b).sum(-1) + traces - 2 * np.sqrt(np.maximum(shared, 0)).sum(-1)
    return np.maximum(distance, 0.0)


def feature_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Return the mean L1 distance of paired features ``(n, d)``, summed over dimensions: "feat_D" of the public code."""
    return float(np.abs(np.asarray(a, np.float64) - np.asarray(b, np.float64)).sum(1).mean())


def matrix_root(matrix: np.ndarray) -> np.ndarray:
    """Return the symmetric square root of positive semidefinite matrices ``(..., d, d)``."""
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.sqrt(np.maximum(values, 0))[..., None, :]) @ np.swapaxes(vectors, -1, -2)
