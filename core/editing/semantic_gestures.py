"""Places semantic gestures of the vocabulary where an edit requests them, and keeps the record of them in the provenance."""

import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..meaning import gesture_blending
from ..meaning.document import Wanted
from ..meaning.gesture import Gesture as VocabularyGesture
from ..meaning.gesture_selection import HOLD, ScheduledGesture, choose_form, emphasis_time
from ..meaning.vocabulary import Vocabulary
from ..motion import limits, skeleton
from ..motion.motion import Motion
from . import frame_ranges, gestures, regeneration
from .gestures import BEAT, REST, Gesture
from .regeneration import Regenerator
from .targets import TRIES, State, StrokeTarget, best_attempt

_PEAK_TO_END = 0.12
"""Typical seconds from a stroke's peak of speed to its end."""
_MAX_PASSES = 6
_INTERPOLATED_ATTEMPT = 1
"""The attempt in which arms are interpolated through the phrase; in the others the generator performs it."""
_SECOND_TRIES = 2
"""Attempts in a second try, in which other gestures are given up."""
_MIN_RELEASE = 0.5
"""Least seconds for the release."""


def gesture_kinds(vocabulary: Vocabulary) -> list[str]:
    """Return all kinds of gesture that an edit can request; marks of transcripts (:data:`hints.HINTS`) are understood, too."""
    return [BEAT, *vocabulary.gestures, REST]


def word_time(words: Sequence[tuple[str, float, float]], word: str, nth: int) -> float:
    """Return the time in seconds of the stroke for the ``nth`` occurrence of a word; raises :class:`UsageError` without one."""
    plain = [gestures.normalize_word(text) for text, *_ in words]
    places = [row for row, text in enumerate(plain) if text == word.lower()]
    if len(places) < nth:
        raise UsageError(f"the word {word!r} is not said {nth} times.", "Give a word of the transcript, or a time.")
    _, start, end = words[places[nth - 1]]
    return emphasis_time(start, end)


def record_meant(motion: Motion, places: Sequence[frame_ranges.FrameRange], shows: Sequence[tuple[str, float]]) -> Motion:
    """Record the semantic gestures ``shows`` (name, seconds) of these places in the provenance; those elsewhere stay."""
    fps = motion.fps
    kept = [one for one in gestures.meant_gestures(motion) if not any(start <= one[1] * fps < stop for start, stop in places)]
    now = sorted(kept + [one for one in shows if one[0] != BEAT], key=lambda one: one[1])
    meta = {name: value for name, value in motion.meta.items() if name != "shows"}
    return replace(motion, meta={**meta, "shows": [[name, round(at, 3)] for name, at in now]} if now else meta)


def place_gesture(
    filler: Regenerator, state: State, edit: dict, at: float, others: Sequence[Gesture], kind: str, hand: str | None,
    size: float, freer: bool = False
) -> tuple[State, float]:  # fmt: skip
    """Place a gesture of the vocabulary with its stroke at ``at`` seconds; return the state and its miss.

    Seed and moment choose the form, the first one is tried last. The phrase around it is regenerated without other strokes.
    ``size`` is relative to the usual size of the gesture, and ``freer`` marks a second try, with other seeds and fewer
    attempts. Raises :class:`UsageError` for an unknown kind and where there is no room."""
    vocabulary, frames = filler.session.vocabulary.gestures, len(state.motion.directions)
    kind = kind if kind in vocabulary else filler.session.vocabulary.marks.get(kind, kind)
    if kind not in vocabulary:
        raise UsageError(f"there is no kind {kind!r}.", f"Kinds are {', '.join(gesture_kinds(filler.session.vocabulary))}.")
    forms = filler.session.vocabulary.forms[kind]
    form = choose_form(forms, (filler.request.keyed_seed, int(10 * at), zlib.crc32(kind.encode())), Wanted(kind))
    seconds = max(form.seconds, forms[0].seconds)
    first, last = int((at - seconds) * skeleton.FPS), int(np.ceil((at + HOLD) * skeleton.FPS))
    if first < 0 or last >= frames:
        raise UsageError(f"there is no room at {at:.2f} s.", "Choose a time farther from beginning and end.")
    place = frame_ranges.range_around(others, first, last, frames)
    overlays = [_Overlay(one, at, hand, place, state.held) for one in (form, forms[0])]
    usual: dict[str, float] = {}

    def make(attempt: int, seed: int) -> Motion:
        again = attempt == _INTERPOLATED_ATTEMPT
        calm = filler.fill(state.motion, [place], None, seed + freer, state.held, again=again)[0]
        if again:
            calm = regeneration.interpolate_arms(calm, place, state.held)
        shown, usual["size"] = overlays[attempt > _INTERPOLATED_ATTEMPT].apply(calm, size)
        return shown

    def miss(motion: Motion) -> float:
        return StrokeTarget(at, hand, size * usual["size"]).miss(motion)

    made, off = best_attempt(filler, state, edit, [place], make, miss, tries=_SECOND_TRIES if freer else TRIES)
    return replace(state, motion=record_meant(made, [place], [(kind, at)])), off


class _Overlay:
    """Lays a gesture of the vocabulary over a phrase without strokes, with its own stroke at a given time."""

    def __init__(
        self, gesture: VocabularyGesture, at: float, hand: str | None, place: frame_ranges.FrameRange, held: np.ndarray
    ):
        self.gesture, self.at, self.hand, self.place, self.held = gesture, at, hand, place, held

    def apply(self, calm: Motion, size: float) -> tuple[Motion, float]:
        """Return the motion with the gesture, ``size`` times as large as usual, and its usual size in metres."""
        arms = replace(calm, hands=None)  # the time of a stroke depends on the arms alone
        motion, lands, _ = self._align(arms, self.at + _PEAK_TO_END, 1.0)
        stroke = gestures.nearest_gesture(motion, self.at)
        usual = stroke.size if stroke is not None else 1.0
        share, next_share = 1.0, size
        for _ in range(_MAX_PASSES if size != 1 and stroke is not None else 0):
            share = next_share
            motion, lands, stroke = self._align(arms, lands, share)
            if stroke is None or abs(stroke.size / (size * usual) - 1) < 0.03:
                break
            next_share = float(np.clip(share * (size * usual / stroke.size) ** 0.8, 0.2, 1.6))
        return (motion if calm.hands is None else self._show(calm, lands, share)), usual

    def _align(self, calm: Motion, lands: float, share: float) -> tuple[Motion, float, Gesture | None]:
        """Shift the end of the stroke, from ``lands`` seconds on, until its peak is at the requested time.

        Returns the best motion, the time its stroke ends, and the stroke itself if one is detected."""
        best = None
        for _ in range(_MAX_PASSES):
            motion = self._show(calm, lands, share)
            stroke = gestures.nearest_gesture(motion, self.at, 0.6)
            off = np.inf if stroke is None else abs(stroke.at - self.at)
            if best is None or off < best[0]:
                best = off, (motion, lands, stroke)
            if stroke is None or off < 0.01:
                break
            lands += 0.8 * (self.at - stroke.at)  # not all of it, since the other arm may become the faster one
        assert best is not None  # the first pass sets it
        return best[1]

    def _show(self, calm: Motion, lands: float, share: float) -> Motion:
        """Return the motion with the gesture, scaled by ``share``, its stroke ending at ``lands`` seconds."""
        start, stop = (frame / skeleton.FPS for frame in self.place)
        until = max(min(lands + HOLD, stop - _MIN_RELEASE), lands + 0.05)
        ready = max(lands - self.gesture.seconds, start + 0.2)
        side = {"left": -1.0, "right": 1.0}.get(self.hand or "", self.gesture.side)
        shown = ScheduledGesture(self.gesture, start, ready, lands, until, stop, side, share)
        which = [(True, True)] if self.hand == "both" else gesture_blending.arms_of_gestures(calm.directions, [shown])
        here = slice(*self.place)
        free = ~self.held[here]
        directions, part = calm.directions.copy(), gesture_blending.blend_gestures(calm.directions, [shown], which)[here]
        directions[here][free] = limits.enforce_limits(part)[free]
        hands = calm.hands
        if hands is not None:
            carried = hands[here].moved_with_arms(calm.directions[here], directions[here])
            hands = regeneration.splice_hands(hands, self.place[0], carried, free)
            hands = regeneration.splice_hands(
                hands, self.place[0], gesture_blending.blend_hands(hands, [shown], which)[here], free
            )
        return replace(calm, directions=directions, hands=hands)
