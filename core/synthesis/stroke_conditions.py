"""Turns a transcript's gesture hints into stroke conditions, for networks that take them."""

from collections.abc import Sequence

import numpy as np

from ..meaning import gesture_selection
from ..motion import skeleton, stroke_requests
from ..words.hints import HINTS, HintEffects

_BOTH = ("all", "big", "small", "thing", "unknown", "maybe")
"""Meanings that people show with both hands."""
_LEFT, _RIGHT, _TWO = 0, 1, 2
_LEFT_LEADS = 0.3
"""The control ``hand`` below minus which the left hand makes strokes."""
_PREPARED, _END = 0.42, 0.14
"""Seconds from a stroke's preparation to its emphasis, and from there to its end: medians of the directed corpus."""
_SIZE = 0.5
"""Path of the wrist in metres: a full stroke of that corpus; the mark's size is applied to the finished motion."""


def conditioned_words(wishes: HintEffects, meanings: Sequence[str]) -> frozenset[int]:
    """Return the numbers of the words whose hinted gesture a network that knows ``meanings`` can be conditioned on."""
    return frozenset(number for number, (hint, _) in wishes.gestures.items() if HINTS[hint].meaning in meanings)


def stroke_channels(
    wishes: HintEffects, words: Sequence, meanings: Sequence[str], frames: int, hand: float | np.ndarray = 0.0
) -> np.ndarray | None:
    """Return strokes and rests as network input ``(frames, 7)`` (:mod:`stroke_requests`), or None where there are none.

    ``words`` are ``(text, start, end)`` in seconds; ``hand`` is the control that says which hand leads, a number
    or ``(frames,)``."""
    numbers = sorted(conditioned_words(wishes, meanings))
    if not meanings or not (numbers or wishes.rests):
        return None
    strokes = [_stroke(*wishes.gestures[number], words[number], meanings, hand) for number in numbers]
    return stroke_requests.encode_requests(
        np.array(strokes, float).reshape(-1, len(stroke_requests.COLUMNS)), np.array(wishes.rests), frames
    )


def _stroke(hint: str, side: float, word: tuple, meanings: Sequence[str], hand: float | np.ndarray) -> tuple:
    """Return a row of :data:`stroke_requests.COLUMNS` for a word."""
    meaning = HINTS[hint].meaning
    emphasis = gesture_selection.emphasis_time(*word[1:3])
    hand = np.ravel(hand)
    leads = hand[min(int(emphasis * skeleton.FPS), len(hand) - 1)] + _LEFT_LEADS
    which = _TWO if meaning in _BOTH and not side else _LEFT if (side or leads) < 0 else _RIGHT
    return 0, emphasis - _PREPARED, emphasis, emphasis + _END, meanings.index(meaning), which, _SIZE
