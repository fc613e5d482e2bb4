"""Gestures of a kind that means something, shown where an edit wants them; and what a take is told to show."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..meaning import showing
from ..meaning.choosing import HOLD, SWING, Shown, emphasis
from ..motion import limits, skeleton
from ..motion.motion import Motion
from . import filling, gestures, spans
from .aims import TRIES, Aim, State, best
from .filling import Filler
from .gestures import BEAT, Gesture

_AHEAD = 0.12
"""Seconds from a stroke's highest speed to where it lands, about."""
_PASSES = 6
_QUIET = 1
"""The attempt in which arms go the shortest way through the phrase; in the others the generator performs it."""
_FREER = 2
"""Times that the phrase is made where others give way."""
_BACK = 0.5
"""Seconds that the way back has at least."""


def names(vocabulary) -> list[str]:
    """All kinds that can be asked for."""
    return [BEAT, *vocabulary.gestures]


def time_of(words: Sequence[tuple[str, float, float]], word: str, nth: int) -> float:
    """Seconds at which a gesture for the ``nth`` such word has its stroke; raises :class:`UsageError`."""
    plain = [gestures.spoken(text) for text, *_ in words]
    places = [row for row, text in enumerate(plain) if text == word.lower()]
    if len(places) < nth:
        raise UsageError(f"the word {word!r} is not said {nth} times.", "Give a word of the transcript, or a time.")
    _, start, end = words[places[nth - 1]]
    return emphasis(start, end)


def told(motion: Motion, places: Sequence[spans.Span], shows: Sequence[tuple[str, float]]) -> Motion:
    """The motion with provenance that tells what it ``shows`` in these places now, and what it showed elsewhere."""
    kept = [one for one in gestures.shows(motion) if not any(a <= one[1] * motion.fps < b for a, b in places)]
    now = sorted(kept + [one for one in shows if one[0] != BEAT], key=lambda one: one[1])
    meta = {name: value for name, value in motion.meta.items() if name != "shows"}
    return replace(motion, meta={**meta, "shows": [[name, round(at, 3)] for name, at in now]} if now else meta)


def shown(
    filler: Filler,
    state: State,
    edit: dict,
    at: float,
    others: Sequence[Gesture],
    kind: str,
    hand: str | None,
    size: float,
    freer: bool = False,
) -> tuple[State, float]:
    """The take with a gesture of the vocabulary whose stroke is at ``at``, in a phrase without any other.

    ``size`` is in sizes that this gesture usually has. ``freer``: where a former one missed, this one has other chances.
    """
    vocabulary, frames = filler.session.vocabulary.gestures, len(state.motion.directions)
    if kind not in vocabulary:
        raise UsageError(f"there is no kind {kind!r}.", f"Kinds are {', '.join(names(filler.session.vocabulary))}.")
    first, last = int((at - SWING) * skeleton.FPS), int(np.ceil((at + HOLD) * skeleton.FPS))
    if first < 0 or last >= frames:
        raise UsageError(f"there is no room at {at:.2f} s.", f"Give a time within 0 to {state.motion.duration:.1f} s.")
    place = spans.around(others, first, last, frames)
    laid = _Laid(vocabulary[kind], at, hand, place, state.held)
    usual: dict[str, float] = {}

    def make(attempt: int, seed: int) -> Motion:
        again = attempt == _QUIET
        calm = filler.fill(state.motion, [place], None, seed + freer, state.held, again=again)[0]
        if again:
            calm = filling.quiet(calm, place, state.held)
        made, usual["size"] = laid.over(calm, size)
        return made

    def miss(motion: Motion) -> float:
        return Aim(at, hand, size * usual["size"]).miss(motion)

    made, off = best(filler, state, edit, [place], make, miss, tries=_FREER if freer else TRIES)
    return replace(state, motion=told(made, [place], [(kind, at)])), off


class _Laid:
    """A gesture of the vocabulary to be laid over a calm phrase so that its stroke is at a time."""

    def __init__(self, gesture, at: float, hand: str | None, place: spans.Span, held: np.ndarray):
        self.gesture, self.at, self.hand, self.place, self.held = gesture, at, hand, place, held

    def over(self, calm: Motion, size: float) -> tuple[Motion, float]:
        """The motion with the gesture, ``size`` times as large as it usually is, and the metres of that usual size."""
        arms = replace(calm, hands=None)  # where strokes land is seen of them alone
        made, lands, _ = self._aligned(arms, self.at + _AHEAD, 1.0)
        one = gestures.nearest(made, self.at)
        usual = one.size if one is not None else 1.0
        share, wanted = 1.0, size
        for _ in range(_PASSES if size != 1 and one is not None else 0):
            share = wanted
            made, lands, one = self._aligned(arms, lands, share)
            if one is None or abs(one.size / (size * usual) - 1) < 0.03:
                break
            wanted = float(np.clip(share * (size * usual / one.size) ** 0.8, 0.2, 1.6))
        return (made if calm.hands is None else self._shown(calm, lands, share)), usual

    def _aligned(self, calm: Motion, lands: float, share: float) -> tuple[Motion, float, Gesture | None]:
        best = None
        for _ in range(_PASSES):
            made = self._shown(calm, lands, share)
            one = gestures.nearest(made, self.at, 0.6)
            off = np.inf if one is None else abs(one.at - self.at)
            if best is None or off < best[0]:
                best = off, (made, lands, one)
            if one is None or off < 0.01:
                break
            lands += 0.8 * (self.at - one.at)  # less than all of it: the other arm may be the faster one then
        return best[1]

    def _shown(self, calm: Motion, lands: float, share: float) -> Motion:
        start, stop = (frame / skeleton.FPS for frame in self.place)
        until = max(min(lands + HOLD, stop - _BACK), lands + 0.05)
        ready = max(lands - SWING, start + 0.2)
        side = {"left": -1.0, "right": 1.0}.get(self.hand or "", 0.0)
        one = Shown(self.gesture, start, ready, lands, until, stop, side, share)
        which = [(True, True)] if self.hand == "both" else showing.sides(calm.directions, [one])
        here = slice(*self.place)
        free = ~self.held[here]
        directions, part = calm.directions.copy(), showing.show(calm.directions, [one], which)[here]
        directions[here][free] = limits.keep_human(part)[free]
        hands = calm.hands
        if hands is not None:
            carried = hands[here].carried(calm.directions[here], directions[here])
            hands = filling.put(hands, self.place[0], carried, free)
            hands = filling.put(hands, self.place[0], showing.hands(hands, [one], which)[here], free)
        return replace(calm, directions=directions, hands=hands)
