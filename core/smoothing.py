"""Smoothing of curves along time with numpy alone; values beyond the ends count as equal to those at the ends."""

import numpy as np


def gaussian(track: np.ndarray, sigma: float) -> np.ndarray:
    """Smooth ``(n, ...)`` along the first axis by a Gaussian of ``sigma`` samples, truncated at 4 sigma; float64."""
    track = np.asarray(track, float)
    if not track.size:
        return track
    reach = int(4 * sigma + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    padded = np.concatenate([np.repeat(track[:1], reach, 0), track, np.repeat(track[-1:], reach, 0)])  # faster than numpy.pad
    return np.apply_along_axis(np.convolve, 0, padded, kernel / kernel.sum(), mode="valid")


def running_mean(track: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of ``size`` samples around each of ``(n,)``, float64; an even window has one more sample before."""
    track = np.asarray(track, float)
    if not len(track):
        return track
    padded = np.pad(track, (size // 2, size - size // 2 - 1), mode="edge")
    total = np.concatenate([[0.0], np.cumsum(padded)])
    return (total[size:] - total[:-size]) / size


def running_maximum(track: np.ndarray, before: int, after: int) -> np.ndarray:
    """Dilate ``(n,)``: each sample extends ``before`` samples earlier and ``after`` samples later, overlaps take the maximum.

    Samples beyond the ends count as 0."""
    if not len(track):
        return track
    padded = np.pad(track, (after, before))
    return np.lib.stride_tricks.sliding_window_view(padded, before + after + 1).max(axis=1)
