"""What an edit aims at, how far a motion is from it, and the best of a few attempts."""

import json
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from . import filling, gestures, joins
from .filling import Filler

LANDS = 0.08
"""Seconds within which a stroke is to land where it was asked for."""
SIZE = 0.15
"""Share by which a size may differ from what was asked for."""
GOOD = 0.4
"""Share of what is allowed that the first attempts are to miss by at most; of later ones what is allowed is enough."""
TRIES = 3
"""Times that a phrase is performed anew at most, until its joins are no more sudden than the take."""
_EASED = 3
"""Attempts whose joins are eased at most."""
_STRIVE = 4
"""Attempts that are to be good, not only allowed."""
LOOSE = 0.35
"""Seconds in which the stroke that was made is looked for."""


@dataclass(frozen=True)
class State:
    """A take after some edits: which frames are ``held`` by them whatever comes, sentences on what could not be had, and
    the styles that begin on the way by them, ``changes`` as a request has them.
    """

    motion: Motion
    held: np.ndarray
    warnings: tuple[str, ...] = ()
    changes: tuple[tuple[float, str], ...] = ()

    @classmethod
    def of(cls, motion: Motion, warnings=()) -> "State":
        """Of a motion at the generator's rate; raises :class:`UsageError` for another."""
        if motion.fps != skeleton.FPS:
            raise UsageError(f"A take of {motion.fps:g} frames a second cannot be directed.", "Direct the .npz of s2ag synth.")
        return cls(motion, np.zeros(len(motion.directions), bool), tuple(warnings))

    def after(self, edits: Sequence[dict]) -> "State":
        """The state of a motion that has these edits in it: the styles that they began, the frames that they keep."""
        held, fps = self.held.copy(), self.motion.fps
        for one in edits:
            if one["do"] in ("pose", "place"):
                first, last = (one["at"], one["at"]) if one["do"] == "pose" else (one["from"], one["to"])
                held[int(np.floor(first * fps + 1e-6)) : int(np.ceil(last * fps - 1e-6)) + 1] = True
        return replace(self, held=held, changes=tuple((one["at"], one["style"]) for one in edits if one["do"] == "style"))


@dataclass(frozen=True)
class Aim:
    """The stroke that is to be there: seconds, hand, metres; None where it does not matter."""

    at: float
    hand: str | None = None
    size: float | None = None

    def miss(self, motion: Motion) -> float:
        """How far off a motion is, in shares of what is allowed: 1 or less is as asked."""
        one = gestures.nearest(motion, self.at, LOOSE)
        if one is None:
            return 20.0
        off = [abs(one.at - self.at) / LANDS]
        off += [10.0 * (one.hand != self.hand)] if self.hand else []
        off += [abs(one.size / self.size - 1) / SIZE] if self.size else []
        return max(off)


def best(
    filler: Filler,
    state: State,
    edit: dict,
    places,
    make: Callable,
    miss: Callable,
    core: Sequence[int] = (),
    tries: int = TRIES,
) -> tuple[Motion, float]:
    """Of a few attempts, ``make(attempt, seed)``, the motion that misses least by ``miss(motion)`` and is no more sudden than
    the take is; frames of the ``core`` are led to, and stay if they can.
    """
    found, least, eased = None, np.inf, 0
    for attempt in range(tries):
        made = make(attempt, seed_of(filler, edit, attempt))
        off, strain = miss(made), filling.strain(state.motion, made, places)
        if off > max(least, 1.0) or (eased >= _EASED and strain > 0):
            continue  # another one promised more, and easing takes as long as several attempts
        least, eased = min(off, least), eased + (strain > 0)
        for one in _rated(state, places, made, off, strain, miss, core):
            found = one if found is None or one[0] < found[0] else found
        if found[0] <= (GOOD if attempt < _STRIVE - 1 else 1):
            break
    return found[1], found[2]


def _rated(
    state: State, places, made: Motion, off: float, strain: float, miss: Callable, core: Sequence[int]
) -> Iterator[tuple[float, Motion, float]]:
    """How good a motion is, 1 or less for as asked, with what it misses; and the same of it with gentler ways if they need
    be, at last in its ``core``, too.
    """
    yield _rating(off, strain), made, off
    kept = state.held.copy()
    kept[list(core)] = True
    for stays in (kept, state.held) if len(core) else (state.held,):
        if strain <= 0:
            break
        softer, strain = joins.eased(state.motion, made, places, stays)
        off = miss(softer)
        yield _rating(off, strain), softer, off


def _rating(off: float, strain: float) -> float:
    """What is had and no more sudden than the take is better than what is more so, however near to what was asked."""
    return max(off, 1.0 if strain > 0 else GOOD) + strain


def seed_of(filler: Filler, edit: dict, attempt: int) -> int:
    """The seed of an attempt at an edit of this take."""
    request = filler.request
    return zlib.crc32(json.dumps([request.seed, request.take, edit, attempt], sort_keys=True).encode())
