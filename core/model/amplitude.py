"""The size of what a regressor performs, which is nearer to the mean than people's."""

from collections.abc import Mapping

import numpy as np

from ..motion import rest, skeleton
from ..motion.interpolation import ramp


def gain_of(meta: Mapping) -> np.ndarray:
    """Return the amplitude correction of each edge ``(9,)``, 1 to 1.4, by the description of a regressor's checkpoint: the
    inverse of the speed ratios measured in validation."""
    validation = meta.get("training", {}).get("validation", {})
    ratios = validation.get("edge_speed_ratios") or [validation.get("speed_ratio", 1.0)] * len(skeleton.EDGES)
    return np.clip(1 / np.maximum(ratios, 1e-3), 1.0, 1.4)


def restore_amplitude(directions: np.ndarray, gain: np.ndarray | float, pose: np.ndarray = rest.REST) -> np.ndarray:
    """Restore the amplitude of a regressor's motion: small deviations from ``pose`` grow by ``gain``, above 95 degrees none.

    ``gain`` is a number, or ``(9,)`` with one for every edge. A network that minimises an error stays nearer to the mean
    than people do; how much is measured on held-out speech. The gain rises over the first second, so that the motion
    starts in its seed pose.
    """
    onset = ramp(np.arange(len(directions)) / skeleton.FPS, 0, 1)[:, None]
    away = np.degrees(rest.angle_between(directions, pose))
    growth = 1 + onset * (gain - 1) * (1 - ramp(away, 35, 95))
    return rest.slerp(np.broadcast_to(pose, directions.shape), directions, growth).astype(np.float32)
