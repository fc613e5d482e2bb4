"""Time warp by loudness: gestures play faster where the voice is loud and more slowly where it is soft.

People's hand speed follows the voice's energy (correlation 0.2 to 0.3); a clip has the speed that suited another speech.
The warp is free between emphases and the identity at each of them, so that strokes still land where they were planned.
"""

import numpy as np

from ...motion import skeleton
from .planning import Stroke
from .scene import Scene

_RATE_PER_DEVIATION = 0.65
"""Increase of the logarithm of playback rate for one standard deviation of loudness."""
_RATE_LIMITS = 0.45, 2.0
"""Slowest and fastest playback rate before the fit to the emphases."""
_SMOOTHING = 0.12
"""Seconds: width of the Gaussian over the level."""
_SILENCE = -25.0
"""Levels below this count as this level."""


def warp_times(strokes: list[Stroke], scene: Scene, time: np.ndarray) -> np.ndarray:
    """Return the planned seconds ``(frames,)`` that the hands show at seconds ``time``; ascending."""
    level = scene.track(np.maximum(scene.prosody.level, _SILENCE), _SMOOTHING, time)
    deviation = max(float(level.std()), 1e-6)
    rate = np.clip(np.exp(_RATE_PER_DEVIATION * (level - level.mean()) / deviation), *_RATE_LIMITS)
    anchors = np.unique([time[0], *(stroke.emphasis for stroke in strokes if time[0] < stroke.emphasis < time[-1]), time[-1]])
    elapsed = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / skeleton.FPS
    at = np.interp(anchors, time, elapsed)
    # stretched linearly between anchors, so that it is the identity at each of them
    return np.interp(elapsed, at, anchors)


def resample(arms: np.ndarray, clock: np.ndarray) -> np.ndarray:
    """Resample directions ``(frames, n, 3)`` at the warped seconds of :func:`warp_times`."""
    from ...motion.motion import sample_directions

    return sample_directions(arms, clock * skeleton.FPS)
