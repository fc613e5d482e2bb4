"""Smoothing along time, as the director does it."""

import numpy as np

from ...motion import skeleton


def smooth(values: np.ndarray, seconds: float, rate: float = skeleton.FPS) -> np.ndarray:
    """Gaussian smoothing along the first axis; the ends repeat."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(np.asarray(values, float), seconds * rate, axis=0, mode="nearest", truncate=3)
