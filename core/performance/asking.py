"""What an author wrote between the lines as strokes that a network is asked for, where it can be asked."""

from collections.abc import Sequence

import numpy as np

from ..meaning import choosing
from ..motion import requested, skeleton
from ..words.hints import Wishes

MEANINGS = {
    "me": "me", "you": "you", "we": "we", "us": "we", "not": "not", "no": "not", "never": "not", "all": "all", "every": "all",
    "question": "question", "stop": "stop", "wait": "stop", "here": "here", "there": "there", "point": "there",
    "think": "think", "maybe": "maybe", "please": "please", "offer": "offer", "give": "offer", "take": "receive",
    "list": "list", "one": "count", "two": "count", "three": "count", "thing": "thing", "example": "example",
    "but": "however", "huge": "big", "wide": "big",
}  # fmt: skip
"""Hint (:data:`hints.GESTURES`) -> the meaning of the stroke that shows it, as corpora name them."""

_BOTH = ("all", "big", "small", "thing", "unknown", "maybe")
"""What people show with both hands."""
_LEFT, _RIGHT, _TWO = 0, 1, 2
_LEADING = 0.3
"""The control of the hand beyond which the left one leads."""
_READY, _END = 0.42, 0.14
"""Seconds from where a stroke is ready to its emphasis, and from there to its end: middles of the directed corpus."""
_SIZE = 0.5
"""Metres of way of the wrist: a full stroke of that corpus; the mark's size comes by arithmetic."""


def asked(wishes: Wishes, meanings: Sequence[str]) -> frozenset[int]:
    """Numbers of the words at which a network that knows ``meanings`` can be asked for the wished gesture."""
    return frozenset(number for number, (hint, _) in wishes.gestures.items() if MEANINGS.get(hint) in meanings)


def channels(
    wishes: Wishes, words: Sequence, meanings: Sequence[str], frames: int, hand: float | np.ndarray = 0.0
) -> np.ndarray | None:
    """Strokes and rests as a network hears of them, ``(frames, 7)`` (:mod:`requested`); None where nothing is wished.

    ``words`` are ``(text, start, end)`` in seconds; ``hand`` is the control that says which hand leads, a number
    or ``(frames,)``.
    """
    told = sorted(asked(wishes, meanings))
    if not meanings or not (told or wishes.rests):
        return None
    strokes = [_stroke(*wishes.gestures[number], words[number], meanings, hand) for number in told]
    return requested.asked(np.array(strokes, float).reshape(-1, len(requested.COLUMNS)), np.array(wishes.rests), frames)


def _stroke(hint: str, side: float, word: tuple, meanings: Sequence[str], hand: float | np.ndarray) -> tuple:
    """A row of :data:`requested.COLUMNS` for a word."""
    meaning = MEANINGS[hint]
    emphasis = choosing.emphasis(*word[1:3])
    hand = np.ravel(hand)
    leads = hand[min(int(emphasis * skeleton.FPS), len(hand) - 1)] + _LEADING
    which = _TWO if meaning in _BOTH and not side else _LEFT if (side or leads) < 0 else _RIGHT
    return 0, emphasis - _READY, emphasis, emphasis + _END, meanings.index(meaning), which, _SIZE
