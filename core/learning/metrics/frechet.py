"""Frechet distance between two sets of features (reference section F.2)."""

import numpy as np

from ...errors import UsageError


def frechet_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Distance of the normal distributions that fit features ``a`` ``(n, d)`` and ``b`` ``(m, d)``.

    ``|m1 - m2|^2 + tr(S1 + S2 - 2 sqrt(S1 S2))`` with unbiased covariances. The trace of the root comes from the
    eigenvalues of a symmetric matrix, so no imaginary parts can appear. Raises :class:`UsageError` for fewer than two
    samples or for values that are not finite.
    """
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if min(len(a), len(b)) < 2:
        raise UsageError("A Frechet distance needs two samples of each set.", "Evaluate more windows.")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise UsageError("Features hold values that are not finite.", "Train the network or the extractor again.")
    cov_a, cov_b = (np.atleast_2d(np.cov(part, rowvar=False)) for part in (a, b))
    root = _root(cov_a)
    shared = np.linalg.eigvalsh(root @ cov_b @ root)
    apart = a.mean(0) - b.mean(0)
    distance = apart @ apart + np.trace(cov_a) + np.trace(cov_b) - 2 * np.sqrt(np.maximum(shared, 0)).sum()
    return float(max(distance, 0.0))


def feature_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Mean L1 distance of paired features ``(n, d)``: "feat_D" of the public code, summed over the dimensions."""
    return float(np.abs(np.asarray(a, np.float64) - np.asarray(b, np.float64)).sum(1).mean())


def _root(matrix: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
