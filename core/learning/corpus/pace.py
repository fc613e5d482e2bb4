"""The hands' own clock: where the voice is loud they go through a gesture faster, where it is soft more slowly.

People's hands follow the voice's energy (performance.md measures 0.2 to 0.3 of correlation); clips bring the speed of somebody
else's speech. Strokes still land where they were planned: the clock runs free between emphases and agrees with the
performance's at each of them.
"""

import numpy as np

from ...motion import skeleton
from .planning import Stroke
from .scene import Scene

_HURRY = 0.65
"""Logarithm of the clock's rate that one standard deviation of loudness adds."""
_RANGE = 0.45, 2.0
"""Slowest and fastest rate of the clock against the performance's."""
_SMOOTH = 0.12
"""Seconds over which loudness is taken."""
_QUIET = -25.0
"""Level below which silence is no softer than silence."""


def clock(strokes: list[Stroke], scene: Scene, time: np.ndarray) -> np.ndarray:
    """Seconds ``(frames,)`` of the planned performance that the hands have reached at seconds ``time``; never backwards."""
    level = scene.track(np.maximum(scene.prosody.level, _QUIET), _SMOOTH, time)
    deviation = max(float(level.std()), 1e-6)
    rate = np.clip(np.exp(_HURRY * (level - level.mean()) / deviation), *_RANGE)
    anchors = np.unique([time[0], *(stroke.emphasis for stroke in strokes if time[0] < stroke.emphasis < time[-1]), time[-1]])
    own = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / skeleton.FPS
    at = np.interp(anchors, time, own)
    # between two anchors the clock is stretched until both agree
    return np.interp(own, at, anchors)


def played(arms: np.ndarray, clock: np.ndarray) -> np.ndarray:
    """Directions ``(frames, n, 3)`` as the hands reach them by their own :func:`clock`."""
    from ...motion.motion import cubic

    return cubic(arms, clock * skeleton.FPS)
