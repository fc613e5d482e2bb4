"""A stroke put into a take: the phrase is performed once, and then bent until the stroke comes out as it was asked for."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion.motion import Motion
from . import cores, filling, gestures, spans
from .aims import LANDS, LOOSE, Aim, State, best
from .cores import Core
from .filling import Filler

_PERFORMED, _ATTEMPTS = 6, 9
"""Attempts whose ways are those of the performance, of all: in the last ones arms go the shortest way there and back."""
_MORE = 1.2
"""By how much more the other arm takes part in the next attempt where it did too little for a stroke of both hands."""
_QUICKER, _QUICKEST = 0.8, 0.6
"""Time that a stroke which is too slow to count takes in the next attempt, and at least, as a share of its own."""
_SLOW = 0.4
"""Metres a second below which a stroke may be too slow to count."""
SECOND = 0.5
"""How near the core of a second try is, where the first one missed."""
_NEARER, _NEAREST = 0.3, 0.9
"""How far the next attempt brings a stroke whose ways are faster than itself to where arms would be without it, and at most,
as a share of the way.
"""


def through(
    filler: Filler,
    state: State,
    edit: dict,
    places: Sequence[spans.Span],
    core: Core,
    aim: Aim,
    whole: bool = False,
    nearer: float = 0.0,
) -> tuple[State, float]:
    """The take with ``places`` made anew through a core, head and trunk too if ``whole``; and what it misses of its aim.

    ``nearer``: where a former one missed, this one begins with a core that is so much nearer to where arms would be.
    """
    here = next(one for one in places if one[0] <= core.first < one[1])
    calm = filling.quiet(state.motion, here, state.held).directions
    tried = _Tried(core, aim, replace(state.motion, directions=calm), whole, nearer)

    def make(attempt: int, seed: int) -> Motion:
        shape = tried.shape()
        made = filler.fill(state.motion, places, shape, seed, state.held, whole=whole, again=attempt + nearer > 0)[0]
        if attempt >= _PERFORMED:
            made = bare(made, places, shape, state.held)
        tried.learn(made, shape, 0.45 if attempt >= _PERFORMED else 0.8)
        return made

    made, miss = best(filler, state, edit, places, make, aim.miss, core.frames, _ATTEMPTS)
    return replace(state, motion=made), miss


class _Tried:
    """What a core must be for its stroke to come out as asked, as far as attempts have told; ``calm`` is the take without."""

    def __init__(self, core: Core, aim: Aim, calm: Motion, whole: bool, nearer: float):
        self._core, self._aim, self._calm, self._whole = core, aim, calm, whole
        self._factor = self._seen = self._share = self._pace = 1.0
        self._nearer, self._later = nearer, 0.0

    def shape(self) -> Core:
        """The core of the next attempt."""
        aim = self._aim
        shape = cores.shared(cores.sized(self._core, self._factor, aim.hand), aim.hand, self._share)
        if self._pace != 1 or self._later:
            shape = cores.paced(shape, aim.at, self._calm, self._pace, self._whole, self._later)
        return cores.nearer(shape, self._calm.directions[shape.frames], self._nearer) if self._nearer else shape

    def learn(self, made: Motion, shape: Core, trust: float) -> None:
        """Look at what came of a core: ways before and behind it belong to its stroke, too."""
        aim, one = self._aim, gestures.nearest(made, self._aim.at, LOOSE)
        off = np.inf if one is None else aim.at - one.at
        slow, far = gestures.speeds(shape.directions).max() < _SLOW, abs(off) > LANDS
        if far and slow and self._pace > _QUICKEST:
            self._pace *= _QUICKER
        elif far and _drowned(made, shape) and self._nearer < _NEAREST:
            self._nearer = min(self._nearer + _NEARER, _NEAREST)
        elif LANDS < abs(off) <= 2 * LANDS:
            self._later += off
        elif far and self._pace > _QUICKEST:
            self._pace *= _QUICKER
        elif one is None:
            self._factor = np.sqrt(self._factor * self._seen)
        else:
            self._seen, self._factor = self._factor, float(np.clip(self._factor * (aim.size / one.size) ** trust, 0.4, 2.5))
            self._share *= 1.0 if one.hand == aim.hand else _MORE if aim.hand == "both" else 1 / _MORE


def _drowned(made: Motion, core: Core) -> bool:
    """Whether arms are faster on their ways to a core and from it than in it."""
    near = round(gestures.APART * made.fps)
    start = max(core.first - near, 0)
    faster = gestures.speeds(made.directions[start : core.last + 1 + near]).max(1)
    return bool(faster.argmax() < core.first - start or faster.argmax() > core.last - start)


def bare(motion: Motion, places, core, held, arms=cores.ARMS, still=None) -> Motion:
    """A motion with nothing but the way to its core and back; it halts at frames ``still``."""
    for start, stop in places:
        for part in ((start, min(stop, core.first)), (max(start, core.last + 1), stop)):
            motion = filling.quiet(motion, part, held, arms, still) if part[1] > part[0] else motion
    return motion
