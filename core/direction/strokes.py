"""A stroke put into a take: the phrase is performed once, and then bent until the stroke comes out as it was asked for."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion.motion import Motion
from . import cores, filling, gestures, spans
from .aims import LANDS, Aim, State, best
from .cores import Core
from .filling import Filler

_PERFORMED = 5
"""Attempts whose ways are those of the performance; in later ones arms go the shortest way there and back."""
_NEARER = (0.0, 0.0, 0.4, 0.7, 0.9)
"""How far in each of those the stroke is made nearer to where arms would be without it, as a share of the way."""
_MORE = 1.2
"""By how much more the other arm takes part in the next attempt where it did too little for a stroke of both hands."""
_QUICKER, _QUICKEST = 0.8, 0.6
"""Time that a stroke which does not stand out takes in the next attempt, and at least, as a share of its own."""


def through(
    filler: Filler, state: State, edit: dict, places: Sequence[spans.Span], core: Core, aim: Aim, whole: bool = False
) -> tuple[State, float]:
    """The take with ``places`` made anew through a core, head and trunk too if ``whole``; and what it misses of its aim."""
    tried = _Tried(core, aim, state.motion, whole)
    here = next(one for one in places if one[0] <= core.first < one[1])
    calm = filling.quiet(state.motion, here, state.held).directions

    def make(attempt: int, seed: int) -> Motion:
        number = attempt - _PERFORMED
        shape = tried.shape(calm, _NEARER[number] if number >= 0 else 0.0)
        made = filler.fill(state.motion, places, shape, seed, state.held, whole=whole, again=attempt > 0)[0]
        if number >= 0:
            made = bare(made, places, shape, state.held)
        tried.learn(made, 0.45 if number >= 0 else 0.8)
        return made

    made, miss = best(filler, state, edit, places, make, aim.miss, core.frames, _PERFORMED + len(_NEARER))
    return replace(state, motion=made), miss


class _Tried:
    """What a core must be for its stroke to come out as asked, as far as attempts have told."""

    def __init__(self, core: Core, aim: Aim, motion: Motion, whole: bool):
        self._core, self._aim, self._motion, self._whole = core, aim, motion, whole
        self._factor = self._seen = self._share = self._pace = 1.0

    def shape(self, calm: np.ndarray, nearer: float) -> Core:
        """The core of the next attempt; ``calm`` ``(frames, 9, 3)`` are the poses of a take without it."""
        shape = cores.shared(cores.sized(self._core, self._factor, self._aim.hand), self._aim.hand, self._share)
        if self._pace < 1:
            shape = cores.paced(shape, self._aim.at, self._motion, self._pace, self._whole)
        return cores.nearer(shape, calm[shape.frames], nearer) if nearer else shape

    def learn(self, made: Motion, trust: float) -> None:
        """Look at what came of it: ways before and behind a core belong to its stroke, too."""
        aim = self._aim
        one = gestures.nearest(made, aim.at)
        if (one is None or abs(one.at - aim.at) > LANDS) and self._pace > _QUICKEST:
            self._pace *= _QUICKER  # it does not stand out
        elif one is None:
            self._factor = np.sqrt(self._factor * self._seen)
        else:
            self._seen, self._factor = self._factor, float(np.clip(self._factor * (aim.size / one.size) ** trust, 0.4, 2.5))
            self._share *= 1.0 if one.hand == aim.hand else _MORE if aim.hand == "both" else 1 / _MORE


def bare(motion: Motion, places, core, held, arms=cores.ARMS, still=None) -> Motion:
    """A motion with nothing but the way to its core and back; it halts at frames ``still``."""
    for start, stop in places:
        for part in ((start, min(stop, core.first)), (max(start, core.last + 1), stop)):
            motion = filling.quiet(motion, part, held, arms, still) if part[1] > part[0] else motion
    return motion
