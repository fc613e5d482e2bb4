"""Diversity of motion across inputs, across sampled styles, and over time (reference section F.5)."""

import numpy as np

from .joint_errors import MILLIMETRES, positions


def diversity(features: np.ndarray, seed: int = 0) -> float:
    """Return the mean L1 distance (summed over dimensions) of features ``(n, d)`` and a random permutation (HA2G)."""
    features = np.asarray(features, np.float64)
    shuffled = features[np.random.default_rng(seed).permutation(len(features))]
    return float(np.abs(features - shuffled).sum(1).mean())


def multimodality(features: np.ndarray) -> float:
    """Return the mean L2 distance of features ``(draws, n, d)`` between draws for the same input; 0 for one draw."""
    features = np.asarray(features, np.float64)
    draws = len(features)
    distances = [np.linalg.norm(features[a] - features[b], axis=1).mean() for a in range(draws) for b in range(a)]
    return float(np.mean(distances)) if distances else 0.0


def l1_diversity(directions: np.ndarray) -> float:
    """Return the mean absolute deviation, in millimetres, of joint coordinates from their mean over the window.

    This is BEAT's L1 diversity divided by the number of coordinates.
    """
    joints = positions(directions)[..., 1:, :]
    return float(np.abs(joints - joints.mean(1, keepdims=True)).mean() * MILLIMETRES)
