"""Baseline performances without content, against which goals are checked: a goal that they reach proves little."""

import numpy as np

from ...motion import rest, skeleton
from ...motion.interpolation import ramp
from .talks import Talk

_UP, _HELD, _DOWN = 0.5, 0.6, 0.8
"""Seconds in which the one gesture is raised, held and lowered."""
_RAISED = skeleton.normalize(np.array([[-0.15, 0.85, 0.4], [-0.1, -0.4, 0.9], [0.15, 0.85, 0.4], [0.1, -0.4, 0.9]]))


def idle(talk: Talk, pose: np.ndarray, seed: int = 0) -> np.ndarray:
    """Return idle motion ``(frames, 9, 3)`` in the resting pose ``(9, 3)``: standing, breathing and swaying."""
    return _add_idle(np.tile(np.asarray(pose, float), (len(talk.loudness), 1, 1)), seed)


def one_gesture(talk: Talk, pose: np.ndarray, seed: int = 0) -> np.ndarray:
    """Return motion ``(frames, 9, 3)`` that raises both hands in the same gesture on every main accent and rests between."""
    time = np.arange(len(talk.loudness)) / skeleton.FPS
    since = time[:, None] - talk.main
    weight = (ramp(since / _UP + 1, 0, 1) * (1 - ramp((since - _HELD) / _DOWN, 0, 1))).max(axis=1, initial=0.0)
    motion = np.tile(np.asarray(pose, float), (len(time), 1, 1))
    for edge, raised in zip(skeleton.ARM_EDGES, _RAISED, strict=True):
        motion[:, edge] = rest.slerp(motion[:, edge], raised, weight)
    return _add_idle(motion, seed)


def _add_idle(motion: np.ndarray, seed: int) -> np.ndarray:
    return skeleton.normalize(motion + rest.idle_offsets(len(motion), seed=seed)).astype(np.float32)


BASELINES = {"resting": idle, "one gesture": one_gesture}
"""Baselines by the name of their column."""
