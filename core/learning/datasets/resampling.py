"""Directions at the frame rate of a data set."""

import numpy as np

from ...motion import skeleton


def resample(values: np.ndarray, fps: float, new_fps: float = skeleton.FPS) -> np.ndarray:
    """Return directions ``(n, 9, 3)`` at another rate, linearly interpolated and normalised; keeps frame 0 (reference B.4)."""
    if not len(values):
        raise ValueError("there are no poses")
    count = max(int(round(len(values) / fps * new_fps)), 1)
    at = np.minimum(np.arange(count) * (fps / new_fps), len(values) - 1)
    low = np.minimum(at.astype(int), max(len(values) - 2, 0))
    share = (at - low)[:, None, None]
    following = values[np.minimum(low + 1, len(values) - 1)]
    return skeleton.normalize(values[low] * (1 - share) + following * share).astype(np.float32)
