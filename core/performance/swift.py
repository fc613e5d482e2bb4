"""Arms that are thrown faster than people's go their way more smoothly: people's wrists pass 2.5 m/s in one frame of a hundred,
4 m/s hardly ever.
"""

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian, running_maximum
from . import keeping, stillness

_USUAL, _SURE = 2.7, 3.7
"""Metres a second up to which a wrist goes its way as it was drawn, and from which on as smoothly as this gets."""
_CALM, _EASE = 0.15, 0.1
"""Seconds: the width of the Gaussian that a way is smoothed by, and how fast that comes and goes."""
_ROUNDS = 3
"""How often that is done at most: what is thrown twice as fast takes more than one."""
_AROUND = 2
"""Frames to each side of one that is too fast that are smoothed as much."""


def slowed(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 without arms that are too fast.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    for _ in range(_ROUNDS):
        before, result = result, _smoothed(result, given)
        if result is before:
            break
    return result


def _smoothed(directions: np.ndarray, given: np.ndarray | tuple) -> np.ndarray:
    """The same once; ``directions`` themselves where nothing is too fast."""
    if len(directions) < 3:
        return directions
    steps = np.linalg.norm(np.diff(skeleton.wrists(directions), axis=0), axis=-1) * skeleton.FPS
    speeds = np.maximum(np.pad(steps, ((1, 0), (0, 0))), np.pad(steps, ((0, 1), (0, 0))))
    if speeds.max() <= _USUAL:
        return directions
    result = directions.copy()
    for side, arm in enumerate(skeleton.ARMS):
        fast = np.clip((speeds[:, side] - _USUAL) / (_SURE - _USUAL), 0, 1)
        if not fast.any():
            continue
        share = gaussian(running_maximum(fast, _AROUND, _AROUND), _EASE * skeleton.FPS) * keeping.free(len(result), given)
        stillness.smooth(result, directions, arm, _CALM, share)
    return result
