"""Lets arms that wait sink until they hang, one or both, as people's do between gestures.

Whether an arm sinks is drawn for each time it waits, by the performer's readiness and the take's own chance.
"""

import math
from collections.abc import Iterator

import numpy as np

from ...model.noise import noise, uniform
from ...motion import rest, skeleton
from ...motion.interpolation import ramp, true_runs
from ...smoothing import gaussian
from .body import Body, Correction, Take

_SALT = 0x51C
_ROOM, _WAIT, _RAISED_WAIT = 0.2, 1.6, 0.5
"""A wrist waits if it stays within ``_ROOM`` metres for ``_WAIT`` s; at shoulder height it sinks ``_RAISED_WAIT`` s later."""
_HARDLY = 0.1
"""Readiness below which arms that have sunk come up again."""
_LOW, _HIGH = 0.38, 0.0
"""Metres of a wrist below its shoulder at which hands are low, and at which they are at the shoulders."""
_SINK, _RISE, _BEFORE, _AFTER = 0.8, 0.6, 0.15, 0.2
"""Seconds in which an arm sinks and rises again, by how many it begins before it waits, and how late it is up again."""
_MIN_DEPTH, _ASTRAY = 0.8, 0.15
"""Least share of the way to hanging, and the random offset of the place where an arm hangs."""
_QUIET, _HANGING = 0.35, 0.12
"""Seconds over which silence comes and goes; a wrist within so many metres of its hanging place counts as hanging."""
_NUMBERS_APART, _OWN = 2.0, 0.3
"""Seconds between two of the numbers that decide, and how much each arm has of its own beside what both have."""


def readiness(hangs: np.ndarray, activity: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """How readily waiting arms sink ``(frames,)``, 0..1.

    In speech as the performer's ``hangs`` ``(frames,)`` say; in silence, by voice ``activity`` ``(frames,)``, always if they
    hang in the rest ``pose`` ``(9, 3)`` or ``(frames, 9, 3)``, and else never. Where ``hangs`` are 0 no arm sinks.
    """
    quiet = 1 - gaussian(activity, _QUIET * skeleton.FPS)
    apart = np.linalg.norm(skeleton.wrists(pose) - skeleton.wrists(rest.REST), axis=-1).max(-1)
    return np.where(hangs > 0, hangs * (1 - quiet) + np.clip(2 - apart / _HANGING, 0, 1) * quiet, 0)


def arm_rest(body: Body, take: Take) -> Iterator[Correction]:
    """Waiting arms hang, and their hands relax as far."""
    if take.ready is None or not take.ready.any():
        return
    frames = len(body.directions)
    free, apart = take.free(frames), np.linalg.norm(body.wrists - skeleton.wrists(rest.REST), axis=-1)
    for arm in body.arms:
        wrist, waits = body.wrists[:, arm.side], _waits(body.wrists[:, arm.side])
        pair, relaxed = arm.pair.astype(np.float32), np.zeros((frames, 2))
        for (start, stop), chance in zip(waits.tolist(), _chances(waits, arm.side, take.key), strict=True):
            if chance[0] > take.ready[start:stop].mean() or apart[start:stop, arm.side].mean() < _HANGING:
                continue
            height = np.clip((_LOW - wrist[start:stop, 1].mean()) / (_LOW - _HIGH), 0, 1)
            here, depth = _depth(frames, start + _RAISED_WAIT * height * skeleton.FPS, stop)
            depth *= (_MIN_DEPTH + (1 - _MIN_DEPTH) * chance[1]) * free[here] * np.clip(take.ready[here] / _HARDLY, 0, 1)
            pair[here] = rest.slerp(pair[here].astype(float), _hanging(arm.side, chance), depth[:, None])
            relaxed[here, arm.side] = np.maximum(relaxed[here, arm.side], depth)
        yield Correction(arm.edges, directions=pair, relaxed=relaxed)


def _waits(wrist: np.ndarray) -> np.ndarray:
    """First and last frame ``(n, 2)`` of the stretches in which a wrist ``(frames, 3)`` stays where it is."""
    width = round(_WAIT * skeleton.FPS)
    if len(wrist) < width:
        return np.zeros((0, 2), int)
    windows = np.lib.stride_tricks.sliding_window_view(np.ascontiguousarray(wrist.T), width, axis=1)
    return true_runs(np.linalg.norm(np.ptp(windows, axis=-1), axis=0) < _ROOM) + (0, width - 1)


def _chances(waits: np.ndarray, side: int, key: tuple) -> np.ndarray:
    """Numbers of each wait ``(n, 4)``, 0..1: whether the arm sinks, how far, and where aside and ahead it hangs then.

    The first number is nearly the same for both arms at one time. A wait's numbers depend on its own time alone.
    """
    at = waits.mean(axis=1) / (_NUMBERS_APART * skeleton.FPS)
    numbers = noise(key[0], key[1], 0, int(at.max(initial=0)) + 2, 9, key[2], _SALT).astype(float)
    own = numbers[:, 1 + 4 * side : 5 + 4 * side]
    own[:, 0] = (numbers[:, 0] + _OWN * own[:, 0]) / math.hypot(1, _OWN)
    return uniform(np.stack([np.interp(at, np.arange(len(own)), column) for column in own.T], axis=-1))


def _hanging(side: int, chance: np.ndarray) -> np.ndarray:
    """Upper arm and forearm ``(2, 3)`` of an arm that hangs a little astray."""
    aside, ahead = _ASTRAY * (2 * chance[2:] - (0.5, 0.5))
    out = aside if side else -aside
    astray = np.array([[out, 0, 0.5 * ahead], [0.5 * out, 0, 1.5 * ahead]])
    return skeleton.normalize(rest.REST[list(skeleton.ARMS[side])] + astray)


def _depth(frames: int, start: float, stop: float) -> tuple[slice, np.ndarray]:
    """Where among all ``frames`` and how far an arm that waits from frame ``start`` to ``stop`` hangs, 0..1."""
    begin, end = start / skeleton.FPS - _BEFORE, stop / skeleton.FPS + _AFTER
    here = slice(max(int(begin * skeleton.FPS), 0), min(int(end * skeleton.FPS) + 2, frames))
    time = np.arange(here.start, here.stop) / skeleton.FPS
    return here, ramp(time, begin, begin + _SINK) * (1 - ramp(time, end - _RISE, end))
