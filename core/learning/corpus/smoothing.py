"""Smoothing along time with SciPy."""

import numpy as np

from ...motion import skeleton


def smooth(values: np.ndarray, seconds: float, rate: float = skeleton.FPS) -> np.ndarray:
    """Smooth along the first axis with a Gaussian of ``seconds``; the end values are repeated."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(np.asarray(values, float), seconds * rate, axis=0, mode="nearest", truncate=3)
