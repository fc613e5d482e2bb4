"""Speaker identification from motion: a linear classifier on statistics of whole performances."""

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


def accuracy(train: np.ndarray, names: np.ndarray, test: np.ndarray, truth: np.ndarray) -> float:
    """Return the share of ``test`` rows whose nearest class mean of ``train``, whitened within classes, is the true one.

    ``train`` and ``test`` ``(n, d)`` features, ``names`` and ``truth`` ``(n,)`` class numbers. This is linear discriminant
    analysis with a shrunk covariance.
    """
    classes = np.unique(names)
    centre, scale = train.mean(axis=0), train.std(axis=0) + 1e-6
    train, test = (train - centre) / scale, (test - centre) / scale
    means = np.stack([train[names == one].mean(axis=0) for one in classes])
    within = train - means[np.searchsorted(classes, names)]
    covariance = within.T @ within / max(len(train) - len(classes), 1)
    covariance += (_SHRINK * np.trace(covariance) / len(covariance) + 1e-6) * np.eye(len(covariance))
    whiten = np.linalg.cholesky(np.linalg.inv(covariance))
    distance = np.linalg.norm((test @ whiten)[:, None] - means @ whiten, axis=-1)
    return float((classes[np.argmin(distance, axis=1)] == truth).mean())
