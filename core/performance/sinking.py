"""Arms that wait while somebody speaks may sink to hang, one or both, as people's do between gestures: a network that was shown
hands waiting before the body keeps them there for whole lines.

Whether an arm sinks is drawn for each time it waits, by the performer's readiness and the take's own chance.
"""

import math

import numpy as np

from ..motion import rest, skeleton
from ..motion.curves import ramp
from ..smoothing import gaussian
from . import keeping
from .noise import noise, uniform

_SALT = 0x51C
_ROOM, _LONG, _HELD = 0.2, 1.6, 0.5
"""Metres that a waiting wrist may go to and fro, seconds from which on it waits, and for how many more it is held before it
sinks if it is as high as the shoulders."""
_HARDLY = 0.1
"""Readiness below which arms that have sunk come up again."""
_LOW, _HIGH = 0.38, 0.0
"""Metres of a wrist below its shoulder at which hands are low, and at which they are at the shoulders."""
_SINKS, _RISES, _BEFORE, _AFTER = 0.8, 0.6, 0.15, 0.2
"""Seconds in which an arm sinks and rises again, by how many it begins before it waits, and how late it is up again."""
_SHALLOW, _ASTRAY = 0.8, 0.15
"""Share of the way to hanging that an arm goes at least, and how far it then is from where another one hangs."""
_QUIET, _HANGING = 0.35, 0.12
"""Seconds over which silence comes and goes; metres of a wrist from where it hangs in which it counts as hanging."""
_EVERY, _OWN = 2.0, 0.3
"""Seconds between two of the numbers that decide, and how much each arm has of its own beside what both have."""


def readiness(hangs: np.ndarray, activity: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """How readily arms sink that wait ``(frames,)``, 0..1.

    In speech as the performer's ``hangs`` ``(frames,)`` say; in silence, of voice ``activity`` ``(frames,)``, always if they
    hang in the ``pose`` ``(9, 3)`` or ``(frames, 9, 3)`` at rest, and else never. Where ``hangs`` are 0 no arm sinks.
    """
    quiet = 1 - gaussian(activity, _QUIET * skeleton.FPS)
    apart = np.linalg.norm(skeleton.wrists(pose) - skeleton.wrists(rest.REST), axis=-1).max(-1)
    return np.where(hangs > 0, hangs * (1 - quiet) + np.clip(2 - apart / _HANGING, 0, 1) * quiet, 0)


def sunk(
    directions: np.ndarray, ready: np.ndarray, key: tuple, given: np.ndarray | tuple = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Directions ``(frames, 9, 3)`` float32 whose waiting arms hang, and how much each of them does ``(frames, 2)``.

    ``ready`` ``(frames,)`` is how readily (:func:`readiness`); ``key`` what :func:`noise` takes to be the take's own: seed,
    identity and speakers. Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result, share = np.array(directions, np.float32), np.zeros((len(directions), 2))
    if not ready.any():
        return result, share
    wrists, free = skeleton.wrists(directions), keeping.free(len(directions), given)
    apart = np.linalg.norm(wrists - skeleton.wrists(rest.REST), axis=-1)
    for side, arm in enumerate(skeleton.ARMS):
        waits = _waits(wrists[:, side])
        for (start, stop), chances in zip(waits.tolist(), _chances(waits, side, key), strict=True):
            if chances[0] > ready[start:stop].mean() or apart[start:stop, side].mean() < _HANGING:
                continue
            height = np.clip((_LOW - wrists[start:stop, side, 1].mean()) / (_LOW - _HIGH), 0, 1)
            here, sinks = _sinks(len(result), start + _HELD * height * skeleton.FPS, stop)
            sinks *= (_SHALLOW + (1 - _SHALLOW) * chances[1]) * free[here] * np.clip(ready[here] / _HARDLY, 0, 1)
            part = result[here, list(arm)].astype(float)
            result[here, list(arm)] = rest.slerp(part, _hanging(side, chances), sinks[:, None])
            share[here, side] = np.maximum(share[here, side], sinks)
    return result, share


def _waits(wrist: np.ndarray) -> np.ndarray:
    """Frames ``(n, 2)`` from and to which a wrist ``(frames, 3)`` stays where it is."""
    width = round(_LONG * skeleton.FPS)
    if len(wrist) < width:
        return np.zeros((0, 2), int)
    seen = np.lib.stride_tricks.sliding_window_view(np.ascontiguousarray(wrist.T), width, axis=1)
    stays = np.linalg.norm(np.ptp(seen, axis=-1), axis=0) < _ROOM
    starts, stops = np.flatnonzero(np.diff(np.concatenate([[0], stays, [0]]).astype(int))).reshape(-1, 2).T
    return np.stack([starts, stops + width - 1], axis=1)


def _chances(waits: np.ndarray, side: int, key: tuple) -> np.ndarray:
    """Numbers of each wait ``(n, 4)``, 0..1: whether the arm sinks, how far, and where aside and ahead it hangs then.

    Both arms have nearly the same first one at the same time, and those of other waits change none.
    """
    at = waits.mean(axis=1) / (_EVERY * skeleton.FPS)
    numbers = noise(key[0], key[1], 0, int(at.max(initial=0)) + 2, 9, key[2], _SALT).astype(float)
    own = numbers[:, 1 + 4 * side : 5 + 4 * side]
    own[:, 0] = (numbers[:, 0] + _OWN * own[:, 0]) / math.hypot(1, _OWN)
    found = np.stack([np.interp(at, np.arange(len(own)), column) for column in own.T], axis=-1)
    return uniform(found)


def _hanging(side: int, chances: np.ndarray) -> np.ndarray:
    """Upper arm and forearm ``(2, 3)`` of an arm that hangs a little astray."""
    aside, ahead = _ASTRAY * (2 * chances[2:] - (0.5, 0.5))
    out = aside if side else -aside
    astray = np.array([[out, 0, 0.5 * ahead], [0.5 * out, 0, 1.5 * ahead]])
    return skeleton.normalize(rest.REST[list(skeleton.ARMS[side])] + astray)


def _sinks(frames: int, start: float, stop: float) -> tuple[slice, np.ndarray]:
    """Where among all ``frames`` and how much an arm that waits from frame ``start`` to ``stop`` hangs."""
    begin, end = start / skeleton.FPS - _BEFORE, stop / skeleton.FPS + _AFTER
    here = slice(max(int(begin * skeleton.FPS), 0), min(int(end * skeleton.FPS) + 2, frames))
    time = np.arange(here.start, here.stop) / skeleton.FPS
    return here, ramp(time, begin, begin + _SINKS) * (1 - ramp(time, end - _RISES, end))
