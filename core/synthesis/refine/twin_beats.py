"""Softens the slower of two arms that are thrown up and dropped at once: people beat so fast with one hand, hardly with both.

The faster arm, which answers the voice, stays as it was drawn, and so does what takes its time.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian, running_maximum
from .body import Body, Correction, Take

_SIZE, _MIN_SIZE = 0.15, 0.1
"""Rise and fall in metres from which a movement is wholly a throw, and up to which it is none."""
_MEASURED = 0.8
"""Share of rise and fall that is timed: slow starts and ends do not count."""
_SLOW, _QUICK = 0.85, 0.67
"""Seconds up and down together: slower than the first is no throw, quicker than the second is wholly one."""
_TOGETHER = 0.2
"""Seconds between the tops of two arms up to which they are thrown together; at twice as many they are not."""
_SMOOTHING, _AROUND, _EASE = 0.3, 0.2, 0.12
"""Seconds: standard deviation of the smoothing, how long before and after its throw an arm is smoothed, and how fast that
comes and goes."""
_NEAR = 5
"""Frames beside a top in which an arm's speed is compared with the other one's."""
_TREMBLE = 0.06
"""Standard deviation in seconds of what is too small to be a top of its own."""


class Throw(NamedTuple):
    """The frame of its ``top``, its highest ``speed`` in metres a frame, ``seconds`` up and down, and how far it is a throw."""

    top: int
    speed: float
    seconds: float
    share: float


def twin_beats(body: Body, take: Take) -> Iterator[Correction]:
    """Smooths the slower arm around its throw."""
    frames = len(body.directions)
    if frames < 3:
        return
    speeds = np.linalg.norm(np.gradient(body.wrists, axis=0), axis=-1)
    heights, speeds = (gaussian(track, _TREMBLE * skeleton.FPS).T for track in (-body.wrists[..., 1], speeds))
    left, right = (_throws(height, speed) for height, speed in zip(heights, speeds, strict=True))
    share = gaussian(_slower(left, right, frames), _EASE * skeleton.FPS) * take.free(frames)[:, None]
    for arm in body.arms:
        yield arm.smooth(_SMOOTHING, share[:, arm.side])


def _slower(left: list[Throw], right: list[Throw], frames: int) -> np.ndarray:
    """How far ``(frames, 2)`` each arm is in a throw in which the other one has a faster part, 0..1."""
    share = np.zeros((frames, 2))
    tops = [throw.top for throw in right]
    window = 2 * _TOGETHER * skeleton.FPS
    for one in left:
        for other in right[bisect_left(tops, one.top - window) : bisect_right(tops, one.top + window)]:
            apart = abs(one.top - other.top) / (_TOGETHER * skeleton.FPS)
            together = min(one.share, other.share, max(2 - apart, 0))
            side = int(other.speed < one.speed)
            slower = (one, other)[side]
            reach = (0.5 * slower.seconds + _AROUND) * skeleton.FPS
            here = slice(max(int(slower.top - reach), 0), int(np.ceil(slower.top + reach)) + 1)
            share[here, side] = np.maximum(share[here, side], together)
    return share


def _throws(height: np.ndarray, speed: np.ndarray) -> list[Throw]:
    """Throws of a wrist by its height and speed ``(frames,)``, in order of time."""
    inner = height[1:-1]
    tops = 1 + np.flatnonzero((inner >= height[:-2]) & (inner > height[2:]) & (_drop(height)[1:-1] > _MIN_SIZE))
    throws = []
    for top in tops.tolist():
        (up, rise), (down, fall) = (_way(height[top] - side) for side in (height[top::-1], height[top:]))
        size, quick = (min(up, down) - _MIN_SIZE) / (_SIZE - _MIN_SIZE), (_SLOW - rise - fall) / (_SLOW - _QUICK)
        share = float(np.clip(min(size, quick), 0, 1))
        if share > 0:
            throws.append(Throw(top, float(speed[max(top - _NEAR, 0) : top + _NEAR + 1].max()), rise + fall, share))
    return throws


def _drop(height: np.ndarray) -> np.ndarray:
    """Metres by which a wrist is lower within the time of a throw, both before and after each frame ``(frames,)``."""
    near = int(np.ceil(_SLOW * skeleton.FPS))
    return height + np.minimum(running_maximum(-height, near, 0), running_maximum(-height, 0, near))


def _way(below: np.ndarray) -> tuple[float, float]:
    """Return how far (m) a wrist falls before it rises above its top or a throw's time is over, and how long (s) that takes.

    ``below`` ``(n,)`` is its drop from the top at each frame.
    """
    below = below[: int(np.ceil(_SLOW * skeleton.FPS)) + 1]
    higher = np.flatnonzero(below < 0)
    below = below[: higher[0]] if len(higher) else below
    size = float(below.max())
    deep = min(_MEASURED * size, _SIZE)
    past = int(np.argmax(below >= deep))
    before = below[past - 1] if past else 0.0
    return size, (past - (below[past] - deep) / max(below[past] - before, 1e-6)) / skeleton.FPS
