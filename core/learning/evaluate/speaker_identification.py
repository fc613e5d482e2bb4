"""Speaker identification from motion: a linear classifier on statistics of performances or long windows of them."""

import numpy as np

from ...motion import skeleton
from . import kinematics

_SHRINK = 0.15
"""Share of the covariance's mean variance added to its diagonal, because features are many and performances few."""


def features(directions: np.ndarray) -> np.ndarray:
    """Return features ``(82,)`` of the style of a performance ``(frames, 9, 3)``.

    Mean and deviation of every direction; 25th, 50th, 75th and 90th percentile of the speed (log of degrees a second) of
    head, upper arms and forearms; the log of left over right for upper arms and forearms; mean, deviation and 90th
    percentile of the wrists' heights.
    """
    directions = np.asarray(directions, float)
    speed = kinematics.angular_speed(directions)[:, [2, *skeleton.ARM_EDGES]]
    quantiles = np.log(np.percentile(speed, (25, 50, 75, 90), axis=0) + 2)
    mean = speed.mean(axis=0)
    sides = np.log((mean[1:3] + 1) / (mean[3:5] + 1))
    heights = -kinematics.wrists(directions)[..., 1]
    high = np.concatenate([heights.mean(axis=0), heights.std(axis=0), np.percentile(heights, 90, axis=0)])
    shape = [directions.mean(axis=0).ravel(), directions.std(axis=0).ravel()]
    return np.concatenate([*shape, quantiles.ravel(), sides, high])


class Judge:
    """Linear discriminant analysis with a shrunk covariance: tells the class of features by the nearest mean, whitened."""

    def __init__(self, features: np.ndarray, names: np.ndarray):
        """Learn from ``features`` ``(n, d)`` of the classes ``names`` ``(n,)``."""
        self.classes = np.unique(names)
        self._centre, self._scale = features.mean(axis=0), features.std(axis=0) + 1e-6
        rows = (features - self._centre) / self._scale
        self._means = np.stack([rows[names == one].mean(axis=0) for one in self.classes])
        within = rows - self._means[np.searchsorted(self.classes, names)]
        covariance = within.T @ within / max(len(rows) - len(self.classes), 1)
        covariance += (_SHRINK * np.trace(covariance) / len(covariance) + 1e-6) * np.eye(len(covariance))
        self._whiten = np.linalg.cholesky(np.linalg.inv(covariance))

    def distances(self, features: np.ndarray) -> np.ndarray:
        """Return the squared distances ``(n, classes)`` of features ``(n, d)`` from the means."""
        rows = (features - self._centre) / self._scale
        return (((rows @ self._whiten)[:, None] - self._means @ self._whiten) ** 2).sum(-1)

    def told(self, features: np.ndarray) -> np.ndarray:
        """Return the classes ``(n,)`` of features ``(n, d)``."""
        return self.classes[self.distances(features).argmin(axis=1)]


def accuracy(train: np.ndarray, names: np.ndarray, test: np.ndarray, truth: np.ndarray) -> float:
    """Return the share of ``test`` rows of which a :class:`Judge` of ``train`` tells the true class.

    ``train`` and ``test`` ``(n, d)`` features, ``names`` and ``truth`` ``(n,)`` class numbers.
    """
    return float((Judge(train, names).told(test) == truth).mean())
