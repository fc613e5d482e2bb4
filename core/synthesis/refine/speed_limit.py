"""Slows what is faster than people's arms, around its time alone: slower passages, and with them the beats, stay to the bit."""

from collections.abc import Iterator

import numpy as np

from ...motion import rest, skeleton
from ...smoothing import gaussian, running_maximum
from .body import Body, Correction

_WRIST, _TURN = 2.7, np.radians(360.0)
"""Metres a second of a wrist, and radians a second of its upper arm or forearm: captured talk passes neither, in 148 s it has
2.67 and 340 degrees at most."""
_WIDTHS = 0.05, 0.075, 0.1, 0.14, 0.2, 0.3
"""Standard deviations in seconds of smoothings, of which the lightest that is slow enough is taken: from one that takes a sixth
off a quick beat (2 Hz) to one that leaves nothing of it."""
_AROUND, _EASE = 4, 0.1
"""Frames to each side that are smoothed as much, and seconds over which smoothing sets in: of a bell, 0.53 s long, all."""


def speed_limit(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Nothing happens where no arm is too fast."""
    if len(body.directions) < 3:
        return
    carried = np.stack([arm.shoulder for arm in body.arms], 1)
    for side, arm in enumerate(body.arms):
        steps, wrong = [arm.pair], [_too_fast(arm.pair, carried[:, side])]
        if not wrong[0].any():
            continue
        for width in _WIDTHS:
            if not np.all(wrong, 0).any():
                break
            steps.append(skeleton.normalize(gaussian(arm.pair, width * skeleton.FPS)))
            wrong.append(_too_fast(steps[-1], carried[:, side]))
        need = np.where(np.all(wrong, 0), len(steps) - 1, np.argmin(wrong, 0)).astype(float)
        level = free * gaussian(running_maximum(need, _AROUND, _AROUND), _EASE * skeleton.FPS)
        here = np.flatnonzero(level)
        low = np.minimum(level[here].astype(int), len(steps) - 2)
        smooth = np.stack(steps)
        start, end = (smooth[number, here] for number in (low, low + 1))
        yield Correction(arm.edges, rest.slerp(start, end, (level[here] - low)[:, None]), here)


def _too_fast(pair: np.ndarray, shoulder: np.ndarray) -> np.ndarray:
    """Return in which frames ``(frames,)`` an arm ``(frames, 2, 3)`` is too fast, to or from its neighbours."""
    lengths = skeleton.LENGTHS[list(skeleton.ARMS[0]), None]
    wrist = skeleton.length(np.diff(shoulder + (pair * lengths).sum(1), axis=0)) / _WRIST
    turn = skeleton.length(np.diff(pair, axis=0)).max(-1) / _TURN
    fast = np.maximum(wrist, turn) * skeleton.FPS > 1
    return np.pad(fast, (1, 0)) | np.pad(fast, (0, 1))
