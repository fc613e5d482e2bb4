"""How varied motion is: across inputs, across draws of the style, and over time (reference section F.5)."""

import numpy as np

from .errors import MILLIMETRES, positions


def diversity(features: np.ndarray, seed: int = 0) -> float:
    """Mean L1 distance (summed over dimensions) of features ``(n, d)`` and a random shuffle of them (HA2G)."""
    features = np.asarray(features, np.float64)
    shuffled = features[np.random.default_rng(seed).permutation(len(features))]
    return float(np.abs(features - shuffled).sum(1).mean())


def multimodality(features: np.ndarray) -> float:
    """Mean L2 distance between features ``(draws, n, d)`` of different draws for the same input; 0 for one draw."""
    features = np.asarray(features, np.float64)
    draws = len(features)
    apart = [np.linalg.norm(features[a] - features[b], axis=1).mean() for a in range(draws) for b in range(a)]
    return float(np.mean(apart)) if apart else 0.0


def l1_diversity(directions: np.ndarray) -> float:
    """Mean absolute departure, in millimetres, of every joint coordinate from its mean over the window (BEAT's L1 diversity,
    divided by the coordinates): motion energy in place.
    """
    joints = positions(directions)[..., 1:, :]
    return float(np.abs(joints - joints.mean(1, keepdims=True)).mean() * MILLIMETRES)
