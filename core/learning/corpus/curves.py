"""Two curves that all movement is made of."""

import numpy as np

from ...motion import skeleton


def ramp(time: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Minimum-jerk rise from 0 at ``begin`` to 1 at ``end``."""
    x = np.clip((time - begin) / max(end - begin, 1e-6), 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x)


def smooth(values: np.ndarray, seconds: float, rate: float = skeleton.FPS) -> np.ndarray:
    """Gaussian smoothing along the first axis; the ends repeat."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(np.asarray(values, float), seconds * rate, axis=0, mode="nearest", truncate=3)
