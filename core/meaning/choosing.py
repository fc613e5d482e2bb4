"""Which of the things said are shown, when, and by which hand: the more readily, the more of them, none upon another."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .gesture import Gesture
from .vocabulary import Vocabulary

LEAD, SWING, HOLD, SINK = 0.5, 0.28, 0.35, 0.75
"""Seconds of preparation, of the stroke itself, of a hold at least, and of the way back."""
_LANDS = 0.4
"""Share of a word after which its vowel is loudest, about."""
_APART = 1.5
"""Seconds between the strokes of two gestures that nobody asked for."""
_SALT = 0x3EA
_SPREAD = 0.12
"""Standard deviation of how large a gesture is shown."""


@dataclass(frozen=True)
class Shown:
    """A gesture with the seconds at which it begins, is ready, lands, is held until, and is over.

    ``side``: -1 by the left hand, 1 by the right, 0 by both or whichever does more; ``size`` is the share of its way that the
    arms go; ``across`` (degrees) turns it further to that side, as lists go.
    """

    gesture: Gesture
    begin: float
    ready: float
    lands: float
    until: float
    end: float
    side: float
    size: float
    across: float = 0.0


def choose(
    vocabulary: Vocabulary,
    words: Sequence[tuple[str, float, float]],
    asked: Mapping[int, tuple[str, float]],
    readiness: float,
    seed: tuple[int, ...],
    found: Mapping[int, tuple[str, int]] | None = None,
) -> list[Shown]:
    """What is shown of ``words`` ``(text, start, end)``, in order of time.

    ``asked`` maps numbers of words to the hint and the side that a transcript's marks ask for: those are shown in any case.
    ``readiness`` 0..1: how much of the rest is. All chance follows from ``seed`` and the word. ``found`` is what
    :func:`occasions` gave of the same words, for who chooses more than once.
    """
    found = occasions(vocabulary, words) if found is None else found
    said = _said(vocabulary, found, readiness, seed)
    for number, (hint, side) in asked.items():
        if hint in vocabulary.marks:
            said[number] = vocabulary.gestures[vocabulary.marks[hint]], 1, side, True
    chosen: list[tuple[int, tuple]] = []
    for number, occasion in sorted(said.items()):
        near = chosen and words[number][1] - words[chosen[-1][0]][1] < _APART
        if near and not occasion[3]:
            continue
        if near and not chosen[-1][1][3]:
            chosen.pop()
        chosen.append((number, occasion))
    return _timed(chosen, words, seed)


def occasions(vocabulary: Vocabulary, words: Sequence[tuple[str, float, float]]) -> Mapping[int, tuple[str, int]]:
    """Number of the bearing word -> the gesture that could show it, and how many words say it."""
    plain = [text.lower().replace("’", "'").strip(".,;:!?\"'()…-–—") for text, *_ in words]
    breaks = [text.rstrip("\"')")[-1:] in ".;:!?…" for text, *_ in words]
    return vocabulary.find(plain, breaks)


def _said(vocabulary: Vocabulary, found: Mapping, readiness: float, seed: tuple[int, ...]) -> dict[int, tuple]:
    """Number of the bearing word -> gesture, how many words say it, side, whether it was asked for."""
    said = {}
    for number, (name, count) in found.items():
        gesture = vocabulary.gestures[name]
        drawn = np.random.default_rng((*seed, _SALT, number, zlib.crc32(name.encode()))).random()
        if drawn < readiness * (gesture.often if count == 1 else 0.5 + 0.5 * gesture.often):
            said[number] = gesture, count, 0.0, False
    return said


def emphasis(start: float, end: float) -> float:
    """Seconds at which a word from ``start`` to ``end`` is loudest, about: there a stroke for it lands."""
    return start + _LANDS * (end - start)


def _timed(chosen: list[tuple[int, tuple]], words: Sequence, seed: tuple[int, ...]) -> list[Shown]:
    shown: list[Shown] = []
    for place, (number, (gesture, count, side, _)) in enumerate(chosen):
        _, start, end = words[number]
        lands = emphasis(start, end)
        after = words[chosen[place + 1][0]][1] - LEAD if place + 1 < len(chosen) else np.inf
        until = min(max(end, lands + HOLD * (1 + 0.5 * (count > 2))), max(after, lands + 0.1))
        random = np.random.default_rng((*seed, _SALT, number))
        size = float(np.clip(1 + random.normal(0, _SPREAD), 0.8, 1.15))
        across = 0.0
        before = shown[-1] if shown else None
        if gesture.arms == "alternate" and not side:
            side = -before.side if before is not None and before.gesture is gesture else (-1.0, 1.0)[int(random.random() < 0.5)]
        if gesture.across:
            row = before.across + gesture.across if before is not None and before.gesture is gesture else -gesture.across
            across = row if row <= 2 * gesture.across else -gesture.across
        begin, ready = max(lands - SWING - LEAD, 0.0), lands - SWING
        if gesture.acted is not None:
            begin = max(lands - gesture.acted.lands, 0.0)
            ready, until = min(begin + LEAD, lands), min(lands + gesture.acted.after, max(after, lands + 0.1))
        shown.append(Shown(gesture, begin, ready, lands, until, until + SINK, side, size, across))
    return shown
