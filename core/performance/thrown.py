"""Of two arms that are thrown up and dropped at once the slower one goes smoothly and not so far: people beat so fast with
one hand, hardly ever with both.

The faster one, which answers the voice, stays as it was drawn, and so does what takes its time.
"""

from bisect import bisect_left, bisect_right

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian, running_maximum
from . import keeping, stillness

_SIZE, _LEAST = 0.15, 0.1
"""Metres that a wrist rises and falls again in a whole throw, and up to which it is none."""
_MOST = 0.8
"""Share of a smaller one's ways that are looked at, because the rest may take any time."""
_LONG, _SURE = 0.85, 0.67
"""Seconds for these ways up and down together from which on they are no throw, and up to which they are one."""
_TOGETHER = 0.2
"""Seconds between the tops of two arms up to which they are thrown together; at twice as many they are not."""
_CALM, _AROUND, _EASE = 0.3, 0.2, 0.12
"""Seconds: the width of the Gaussian that the slower arm is smoothed by, how long before and after its throw, and how fast
that comes and goes."""
_NEAR = 5
"""Frames beside a top in which an arm's speed is compared with the other one's."""
_TREMBLE = 0.06
"""The same, of what is too small to be a top of its own."""


def calmed(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 with one arm at most that is thrown up and down at once.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    if len(result) < 3:
        return result
    wrists = skeleton.wrists(directions)
    speeds = np.linalg.norm(np.gradient(wrists, axis=0), axis=-1)
    ways = (gaussian(track, _TREMBLE * skeleton.FPS).T for track in (-wrists[..., 1], speeds))
    share = gaussian(_slower(*map(_throws, *ways), len(result)), _EASE * skeleton.FPS)
    share *= keeping.free(len(result), given)[:, None]
    for side, arm in enumerate(skeleton.ARMS):
        stillness.smooth(result, directions, arm, _CALM, share[:, side])
    return result


def _slower(left: list, right: list, frames: int) -> np.ndarray:
    """How much ``(frames, 2)`` each arm is in a throw in which the other one has a faster part."""
    share = np.zeros((frames, 2))
    tops = [throw[0] for throw in right]
    most = 2 * _TOGETHER * skeleton.FPS
    for one in left:
        for other in right[bisect_left(tops, one[0] - most) : bisect_right(tops, one[0] + most)]:
            apart = abs(one[0] - other[0]) / (_TOGETHER * skeleton.FPS)
            together = min(one[3], other[3], max(2 - apart, 0))
            side = int(other[1] < one[1])
            top, _, long, _ = (one, other)[side]
            reach = (0.5 * long + _AROUND) * skeleton.FPS
            here = slice(max(int(top - reach), 0), int(np.ceil(top + reach)) + 1)
            share[here, side] = np.maximum(share[here, side], together)
    return share


def _throws(height: np.ndarray, speed: np.ndarray) -> list[tuple[int, float, float, float]]:
    """Tops of a wrist's way: the frame, metres a frame at most, seconds up and down, and how much of a throw that is, 0..1."""
    inner = height[1:-1]
    tops = 1 + np.flatnonzero((inner >= height[:-2]) & (inner > height[2:]) & (_lower(height)[1:-1] > _LEAST))
    found = []
    for top in tops.tolist():
        (up, rises), (down, falls) = (_fall(height[top] - way) for way in (height[top::-1], height[top:]))
        long = rises + falls
        share = float(np.clip(min((min(up, down) - _LEAST) / (_SIZE - _LEAST), (_LONG - long) / (_LONG - _SURE)), 0, 1))
        if share > 0:
            fastest = float(speed[max(top - _NEAR, 0) : top + _NEAR + 1].max())
            found.append((top, fastest, long, share))
    return found


def _lower(height: np.ndarray) -> np.ndarray:
    """Metres by which a way ``(frames,)`` is lower somewhere within the time of a throw, both before and after each frame."""
    near = int(np.ceil(_LONG * skeleton.FPS))
    return height + np.minimum(running_maximum(-height, near, 0), running_maximum(-height, 0, near))


def _fall(below: np.ndarray) -> tuple[float, float]:
    """Metres by which a way goes down from its top, ``below`` that frame by frame, before it is higher again or a throw would
    be over; and seconds until it is as low as a throw goes.
    """
    below = below[: int(np.ceil(_LONG * skeleton.FPS)) + 1]
    higher = np.flatnonzero(below < 0)
    below = below[: higher[0]] if len(higher) else below
    size = float(below.max())
    deep = min(_MOST * size, _SIZE)
    past = int(np.argmax(below >= deep))
    before = below[past - 1] if past else 0.0
    return size, (past - (below[past] - deep) / max(below[past] - before, 1e-6)) / skeleton.FPS
