"""Performances that nobody would film, against which goals are tried: a goal that they reach says little by itself."""

import numpy as np

from ...motion import rest, skeleton
from ...motion.curves import ramp
from .talks import Talk

_UP, _HELD, _DOWN = 0.5, 0.6, 0.8
"""Seconds in which the one gesture is raised, held and lowered."""
_RAISED = skeleton.normalize(np.array([[-0.15, 0.85, 0.4], [-0.1, -0.4, 0.9], [0.15, 0.85, 0.4], [0.1, -0.4, 0.9]]))


def resting(talk: Talk, pose: np.ndarray, seed: int = 0) -> np.ndarray:
    """Somebody who only stands, breathes and sways ``(frames, 9, 3)``, in the resting pose ``(9, 3)``."""
    return _idling(np.tile(np.asarray(pose, float), (len(talk.loudness), 1, 1)), seed)


def one_gesture(talk: Talk, pose: np.ndarray, seed: int = 0) -> np.ndarray:
    """Somebody who raises both hands on every main accent, always the same way, and rests in between."""
    time = np.arange(len(talk.loudness)) / skeleton.FPS
    since = time[:, None] - talk.main
    weight = (ramp(since / _UP + 1, 0, 1) * (1 - ramp((since - _HELD) / _DOWN, 0, 1))).max(axis=1, initial=0.0)
    motion = np.tile(np.asarray(pose, float), (len(time), 1, 1))
    for edge, raised in zip(skeleton.ARM_EDGES, _RAISED, strict=True):
        motion[:, edge] = rest.slerp(motion[:, edge], raised, weight)
    return _idling(motion, seed)


def _idling(motion: np.ndarray, seed: int) -> np.ndarray:
    return skeleton.normalize(motion + rest.idle(len(motion), seed=seed)).astype(np.float32)


DULL = {"resting": resting, "one gesture": one_gesture}
"""By the name of their column."""
