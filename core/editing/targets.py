"""The target of an edit, how far a motion misses it, and the choice of the best of a few attempts."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from . import gestures, regeneration, transitions
from .edits import FEELINGS, active
from .frame_ranges import FrameRange
from .regeneration import Regenerator

LANDS = 0.08
"""Seconds by which a stroke may miss the requested time."""
SIZE = 0.15
"""Share by which a stroke's size may differ from the requested one."""
GOOD = 0.4
"""Largest miss, as a share of the tolerance, that ends the search in early attempts; later ones end it within the tolerance."""
TRIES = 3
"""Default number of attempts to regenerate a phrase with joins no more sudden than the take."""
_MAX_EASED = 3
"""Most attempts whose joins are eased, which is slow."""
_STRICT_ATTEMPTS = 4
"""The first attempts up to this one end the search by :data:`GOOD`, not by the tolerance alone."""
LOOSE = 0.35
"""Seconds around the requested time in which the resulting stroke is searched for."""


@dataclass(frozen=True)
class State:
    """A take after some edits.

    ``held`` ``(frames,)`` marks frames that later edits must not change, ``warnings`` are sentences on what failed, and
    ``changes`` are the style changes that edits added, as (seconds, style) like those of a request, ``feelings`` the changes of
    feeling, as (seconds, ``{affect: value}``)."""

    motion: Motion
    held: np.ndarray
    warnings: tuple[str, ...] = ()
    changes: tuple[tuple[float, str], ...] = ()
    feelings: tuple[tuple[float, dict[str, float]], ...] = ()

    @classmethod
    def of(cls, motion: Motion, warnings: Sequence[str] = ()) -> "State":
        """Return the state of an unedited motion; raises :class:`UsageError` if it is not at the generator's frame rate."""
        if motion.fps != skeleton.FPS:
            raise UsageError(f"A take of {motion.fps:g} frames a second cannot be directed.", "Direct the .npz of s2ag synth.")
        return cls(motion, np.zeros(len(motion.directions), bool), tuple(warnings))

    def after(self, edits: Sequence[dict]) -> "State":
        """Return the state of a motion that contains these edits: with their style changes, and the frames that they fix."""
        edits, held, fps = active(edits), self.held.copy(), self.motion.fps
        for edit in edits:
            if edit["do"] in ("pose", "place"):
                first, last = (edit["at"], edit["at"]) if edit["do"] == "pose" else (edit["from"], edit["to"])
                held[int(np.floor(first * fps + 1e-6)) : int(np.ceil(last * fps - 1e-6)) + 1] = True
        styled, felt = turns(edits)
        return replace(self, held=held, changes=styled, feelings=felt)


def turns(edits: Sequence[dict]) -> tuple[tuple, tuple]:
    """Return the changes of style and of feeling that edits make, as a :class:`State` has them."""
    feelings = ((one["at"], {name: one[name] for name in FEELINGS if name in one}) for one in edits if one["do"] == "feel")
    return tuple((one["at"], one["style"]) for one in edits if one["do"] == "style"), tuple(feelings)


@dataclass(frozen=True)
class StrokeTarget:
    """The stroke that an edit requests: its time in seconds, its hand and its size in metres; None where any will do."""

    at: float
    hand: str | None = None
    size: float | None = None

    def miss(self, motion: Motion) -> float:
        """Return how far a motion misses this target, relative to the tolerances: 1 or less is within them."""
        stroke = gestures.nearest_gesture(motion, self.at, LOOSE)
        if stroke is None:
            return 20.0
        misses = [abs(stroke.at - self.at) / LANDS]
        misses += [10.0 * (stroke.hand != self.hand)] if self.hand else []
        misses += [abs(stroke.size / self.size - 1) / SIZE] if self.size else []
        return max(misses)


def best_attempt(
    filler: Regenerator, state: State, edit: dict, places: Sequence[FrameRange], make: Callable[[int, int], Motion],
    miss: Callable[[Motion], float], core: Sequence[int] | np.ndarray = (), tries: int = TRIES
) -> tuple[Motion, float]:  # fmt: skip
    """Return the best motion of several attempts ``make(attempt, seed)``, and its miss ``miss(motion)``.

    The best one misses least and is no more sudden than the take. Frame numbers in ``core`` stay unchanged while joins are
    eased, if that is enough."""
    winner, least, eased = None, np.inf, 0
    for attempt in range(tries):
        candidate = make(attempt, filler.attempt_seed(edit, attempt))
        off, strain = miss(candidate), regeneration.join_strain(state.motion, candidate, places)
        if off > max(least, 1.0) or (eased >= _MAX_EASED and strain > 0):
            continue  # an earlier attempt is better, and easing takes as long as several attempts
        least, eased = min(off, least), eased + (strain > 0)
        for rated in _rate_variants(state, places, candidate, off, strain, miss, core):
            winner = rated if winner is None or rated[0] < winner[0] else winner
        if winner is not None and winner[0] <= (GOOD if attempt < _STRICT_ATTEMPTS - 1 else 1):
            break
    assert winner is not None  # the first attempt is always rated
    return winner[1], winner[2]


def _rate_variants(
    state: State, places: Sequence[FrameRange], candidate: Motion, off: float, strain: float, miss: Callable[[Motion], float],
    core: Sequence[int] | np.ndarray
) -> Iterator[tuple[float, Motion, float]]:  # fmt: skip
    """Yield (rating, motion, miss) of a candidate, and of variants with eased joins while it is more sudden than the take.

    A rating of 1 or less is within the tolerances. The first variant keeps the ``core``, the second may change it, too."""
    yield _rating(off, strain), candidate, off
    kept = state.held.copy()
    kept[list(core)] = True
    for stays in (kept, state.held) if len(core) else (state.held,):
        if strain <= 0:
            break
        softer, strain = transitions.ease_joins(state.motion, candidate, places, stays)
        off = miss(softer)
        yield _rating(off, strain), softer, off


def _rating(off: float, strain: float) -> float:
    """Rate a motion, lower is better: one that is no more sudden than the take beats every other within the tolerances."""
    return max(off, 1.0 if strain > 0 else GOOD) + strain
