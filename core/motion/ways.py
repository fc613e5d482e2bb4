"""Ways of the arms from one pose to another that are no strokes: over the rest pose, or straight."""

import numpy as np

from . import rest, skeleton
from .interpolation import ramp

HOME, RISE = (1.0, 1.4, 1.9, 2.6, 3.4), (0.8, 1.1, 1.5, 2.0, 2.7)
"""Seconds in which hands go home, and rise again; the first that work are taken."""
WAYS = ("eased", "even", "first", "last", "both")
"""How fast a way goes that is not led over the rest pose: evenly, or as the strokes on either side of it fade."""
PACES, _LATER = ("eased", "even", "late"), 1.8
"""How fast hands go home and rise, and the exponent by which those that rise late are fastest near the next stroke."""
SLOW = 0.22 / skeleton.FPS
"""Metres a frame that are no stroke, however far they lead."""
ARMS = (3, 4, 5, 6, 7, 8)
"""Edges of both arms, from the neck to the wrists."""
_FADE_FRAMES = 9
"""Frames in which a stroke's speed fades into a way, or grows out of it."""
_RAMP = 0.35
"""Seconds in which an even way reaches its speed."""


def path(
    directions: np.ndarray, home: np.ndarray, start: int, stop: int, plan: tuple | str, pace: str, frames: int
) -> np.ndarray:
    """Return directions ``(stop - start, 9, 3)`` of a way between the poses on either side of the frames.

    ``plan`` are the seconds of the way home and up again, at one of :data:`PACES`; or it is one of :data:`WAYS`. Speeds at
    its ends fade in ``frames``."""
    count, fps = stop - start, skeleton.FPS
    t = np.arange(1, count + 1)
    low, high = directions[max(start - 1, 0)].astype(float), directions[stop].astype(float) if stop < len(directions) else None
    if isinstance(plan, str) and high is not None:
        way = rest.slerp(low, high, _straight(low, high, count, plan)[:, None])
    else:
        down, up = (seconds * fps for seconds in (plan if isinstance(plan, tuple) else (HOME[1], RISE[1])))
        if high is not None and down + up > count + 1:
            down, up = (part * (count + 1) / (down + up) for part in (down, up))
        way = rest.slerp(low, home[start:stop], _share(t / down, pace == "even", down)[:, None])
        if high is not None:
            rise = np.clip((t - (count + 1 - up)) / up, 0, 1) ** (_LATER if pace == "late" else 1.0)
            way = rest.slerp(way, high, _share(rise, pace == "even", up)[:, None])
    length = min(frames, count)
    if start > 2:
        way += _fading(t, length)[:, None, None] * _speed(directions[start - 3 : start][::-1])
    if stop + 2 < len(directions):
        way += _fading(t[::-1], length)[:, None, None] * _speed(directions[stop : stop + 3])
    result = np.array(directions[start:stop])
    result[:, ARMS] = skeleton.normalize(way)[:, ARMS]
    return result


def _speed(poses: np.ndarray) -> np.ndarray:
    """Return the change a frame ``(9, 3)`` at the first of three poses ``(3, 9, 3)``, on the way away from the second one."""
    first, second, third = poses.astype(float)
    return 0.5 * (3 * first - 4 * second + third)


def _straight(low: np.ndarray, high: np.ndarray, count: int, way: str) -> np.ndarray:
    """Return the share done ``(count,)`` in the frames between two poses on one of :data:`WAYS`."""
    if way in WAYS[:2]:
        return _share(np.arange(1, count + 1) / (count + 1), way == "even", count + 1.0)
    far = float(np.linalg.norm(np.diff(skeleton.wrists(np.stack([low, high])), axis=0), axis=-1).max())
    steps = np.arange(count + 1)
    first, last = (np.clip(1 - side / _FADE_FRAMES, 0, 1) for side in (steps, steps[::-1]))
    faster = first * (way != "last") + last * (way != "first")
    more = max(far - SLOW * (count + 1), 0.0) / faster.sum()
    speed = min(SLOW, far / (count + 1)) + more * faster
    return np.cumsum(speed)[:-1] / max(speed.sum(), 1e-9)


def _share(t: np.ndarray, even: bool, frames: float) -> np.ndarray:
    """Return the share of a way that is done at shares ``t`` of its time, beginning and ending at rest."""
    t = np.clip(t, 0, 1)
    if not even:
        return ramp(t, 0.0, 1.0)
    rising = min(_RAMP * skeleton.FPS / frames, 0.5)
    top = 1 / (1 - rising)
    done = np.where(t < rising, 0.5 * top * t**2 / rising, top * (t - 0.5 * rising))
    return np.where(t > 1 - rising, 1 - 0.5 * top * (1 - t) ** 2 / rising, done)


def _fading(t: np.ndarray, frames: int) -> np.ndarray:
    """Return the frames that a speed of one goes on for until it has faded, at ``t`` frames after its beginning."""
    share = np.clip(t / max(frames, 1), 0, 1)
    return frames * share * (1 - share) ** 2
