"""Selects which phrases get a semantic gesture, with its times and hand, so that gestures do not overlap."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from . import places, sentence
from .document import Wanted
from .gesture import STROKE, Gesture
from .vocabulary import Vocabulary

PREPARATION, HOLD, RETRACTION = 0.5, 0.35, 0.75
"""Seconds of preparation, of the shortest hold, and of the retraction."""
_EMPHASIS_SHARE = 0.4
"""Share of a word after which it is loudest, approximately."""
_MIN_INTERVAL = 1.5
"""Seconds between the words of two gestures, unless a mark requests them."""
_AROUND, _MOST_AROUND = 15.0, 3
"""Within so many seconds to both sides at most so many others: people show two to six meanings a minute."""
_LEAST_SCORE = 0.5
"""How surely a meaning must be understood: a false one is worse than none."""
_SALT = 0x3EA
_LATER = 0.5
"""Share of a longer stroke that follows the word, so that its middle meets it."""
_SIZE_DEVIATION = 0.12
"""Standard deviation of the size of gestures."""


@dataclass(frozen=True)
class ScheduledGesture:
    """A scheduled gesture: times in seconds of its start, the start and end of the stroke, and the ends of hold and retraction.

    ``side``: -1 for the left hand, 1 for the right, 0 for both or the one that moves more; ``size`` scales the way of the arms;
    ``across`` (degrees) turns it further to that side, for the successive items of a list."""

    gesture: Gesture
    begin: float
    ready: float
    lands: float
    until: float
    end: float
    side: float
    size: float
    across: float = 0.0


def choose_gestures(
    vocabulary: Vocabulary, words: Sequence[tuple[str, float, float]], asked: Mapping[int, tuple[str, float]], readiness: float,
    seed: tuple[int, ...], found: Mapping[int, Wanted] | None = None
) -> list[ScheduledGesture]:  # fmt: skip
    """Choose the gestures of ``words`` ``(text, start, end)``, in order of time.

    ``asked`` maps word numbers to the hint and side of the transcript's marks, which are always shown. ``readiness`` 0..1 is
    the share of the other occasions that are. Random choices depend on ``seed`` and the word only. ``found`` is the result of
    :func:`find_occasions` or :func:`document.find` for the same words, if the caller has it."""
    found = find_occasions(vocabulary, words) if found is None else found
    drawn = _draw_gestures(vocabulary, found, readiness, seed)
    chosen: dict[int, Wanted] = {at: one for at, one in found.items() if one.sure is None}
    for number, wanted in sorted(drawn.items(), key=lambda one: (-(one[1].sure or 0), one[0])):
        apart = [abs(words[number][1] - words[other][1]) for other in chosen]
        if min(apart, default=np.inf) >= _MIN_INTERVAL and sum(one < _AROUND for one in apart) < _MOST_AROUND:
            chosen[number] = wanted
    # Marks come last and only take the place of what is near, so that they change nothing that is far away.
    marked = {at: Wanted(vocabulary.marks[hint], side=side or None) for at, (hint, side) in asked.items()
              if hint in vocabulary.marks}  # fmt: skip
    for at in marked:
        chosen = {one: what for one, what in chosen.items() if abs(words[one][1] - words[at][1]) >= _MIN_INTERVAL}
    chosen |= marked
    return _schedule(vocabulary, sorted(chosen.items()), words, seed)


def find_occasions(
    vocabulary: Vocabulary, words: Sequence[tuple[str, float, float]], language: str | None = None
) -> dict[int, Wanted]:
    """Return what has a gesture, by the number of the word that carries it.

    A user's own phrases come before what is understood of the sentences (:mod:`sentence`) in a ``language`` (None: English)."""
    texts = [text for text, *_ in words]
    normal = [text.lower().replace("’", "'").strip(".,;:!?\"'()…-–—") for text in texts]
    breaks = [text.rstrip("\"')")[-1:] in ".;:!?…" for text in texts]
    phrases = vocabulary.find(normal, breaks).items()
    found = {at: Wanted(name, count, 1.0, before=bearer) for at, (name, count, bearer) in phrases}
    grammar = sentence.load_grammar(language)
    for one in sentence.understand(texts, grammar) if grammar is not None else ():
        free = not any(at in found for at in range(one.first, one.last + 1))
        if free and one.schema in vocabulary.gestures and one.score >= _LEAST_SCORE:
            found[one.bearer] = Wanted(one.schema, one.last - one.first + 1, one.score, before=one.bearer - one.first)
    return found if grammar is None else places.remember(found, texts, grammar, vocabulary.forms)


def _draw_gestures(vocabulary: Vocabulary, found: Mapping, readiness: float, seed: tuple[int, ...]) -> dict[int, Wanted]:
    """Draw which occasions are used, of those that are not shown in any case."""
    drawn = {}
    for number, wanted in found.items():
        gesture = vocabulary.gestures[wanted.schema]
        chance = np.random.default_rng((*seed, _SALT, number, zlib.crc32(wanted.schema.encode()))).random()
        often = gesture.often if wanted.count == 1 else 0.5 + 0.5 * gesture.often
        if wanted.sure is not None and chance < readiness * often:
            drawn[number] = wanted
    return drawn


def emphasis_time(start: float, end: float) -> float:
    """Return the approximate time in seconds of the loudest point of a word, where a stroke for it ends."""
    return start + _EMPHASIS_SHARE * (end - start)


def choose_form(forms: Sequence[Gesture], seed: tuple[int, ...], wanted: Wanted) -> Gesture:
    """Return the form that a document asks for, or one by ``seed``; with both arms where it asks for both."""
    number = int(np.random.default_rng(seed).integers(len(forms))) if wanted.form is None else wanted.form - 1
    gesture = forms[number % len(forms)]
    return replace(gesture, arms="both") if wanted.side == 0 else gesture


def _schedule(
    vocabulary: Vocabulary, chosen: list[tuple[int, Wanted]], words: Sequence[tuple[str, float, float]], seed: tuple[int, ...]
) -> list[ScheduledGesture]:
    """Determine times, side, size and direction of the chosen gestures."""
    shown: list[ScheduledGesture] = []
    for place, (number, wanted) in enumerate(chosen):
        _, start, end = words[number]
        name, count, side = wanted.schema, wanted.count, wanted.side
        gesture = choose_form(vocabulary.forms[name], (*seed, _SALT, number, 1), wanted)
        lands = emphasis_time(start, end) + _LATER * (gesture.seconds - STROKE)
        after = words[chosen[place + 1][0]][1] - PREPARATION if place + 1 < len(chosen) else np.inf
        until = min(max(end, lands + HOLD * (1 + 0.5 * (count > 2))), max(after, lands + 0.1))
        random = np.random.default_rng((*seed, _SALT, number))
        size = float(np.clip(1 + random.normal(0, _SIZE_DEVIATION), 0.8, 1.15)) * (wanted.size or 1)
        across = 0.0
        before = shown[-1] if shown else None
        side = gesture.side if side is None else side
        if gesture.arms == "alternate" and not side:
            again = before is not None and before.gesture.name == name
            side = -before.side if before is not None and again else (-1.0, 1.0)[int(random.random() < 0.5)]
        if gesture.across:
            row = before.across + gesture.across if before is not None and before.gesture.name == name else -gesture.across
            across = row if row <= 2 * gesture.across else -gesture.across
        begin, ready = max(lands - gesture.seconds - PREPARATION, 0.0), max(lands - gesture.seconds, 0.0)
        if gesture.acted is not None:
            begin = max(lands - gesture.acted.lands, 0.0)
            ready, until = min(begin + PREPARATION, lands), min(lands + gesture.acted.after, max(after, lands + 0.1))
        shown.append(ScheduledGesture(gesture, begin, ready, lands, until, until + RETRACTION, side, size, across))
    return shown
