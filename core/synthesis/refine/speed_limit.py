"""Limits wrist speed by local smoothing: people's wrists pass 2.5 m/s in one frame of a hundred, 4 m/s hardly ever."""

from collections.abc import Iterator

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian, running_maximum
from .body import Body, Correction, Take

_USUAL, _FASTEST = 2.7, 3.7
"""Metres a second up to which an arm stays as it was drawn, and from which on it is smoothed wholly."""
_SMOOTHING, _EASE = 0.15, 0.1
"""Standard deviations in seconds: of the smoothing, and over which it sets in."""
_AROUND = 2
"""Frames to each side of a fast one that are smoothed as much."""


def speed_limit(body: Body, take: Take) -> Iterator[Correction]:
    """One pass; nothing happens where no wrist is too fast."""
    if len(body.directions) < 3:
        return
    steps = np.linalg.norm(np.diff(body.wrists, axis=0), axis=-1) * skeleton.FPS
    speeds = np.maximum(np.pad(steps, ((1, 0), (0, 0))), np.pad(steps, ((0, 1), (0, 0))))
    excess = np.clip((speeds - _USUAL) / (_FASTEST - _USUAL), 0, 1)
    for side in np.flatnonzero(excess.any(axis=0)).tolist():
        share = gaussian(running_maximum(excess[:, side], _AROUND, _AROUND), _EASE * skeleton.FPS)
        yield body.arms[side].smooth(_SMOOTHING, share * take.free(len(share)))
