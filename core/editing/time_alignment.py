"""Aligns the times of two recordings of the same words.

The map passes near all words that both have with as little change of tempo as possible, and is then smoothed as far as these
words allow."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import UsageError
from ..smoothing import gaussian
from .edits import TURNS, active
from .gestures import normalize_word

_TOLERANCE, _MIN_TEMPO = 0.03, 0.2
"""Seconds by which the map may miss a word, and the least factor on them where the new recording is slower."""
_SMOOTHING = (0.2, 0.12, 0.08, 0.05, 0.03, 0.02)
"""Widths in seconds of the smoothing: the first one is used that misses no word by more than twice its tolerance."""
_MIN_COMMON = 0.5
"""Share of the words of both recordings that must be the same."""
_STEP = 0.01
_ITERATIONS = 400
_MIN_STEP = 1e-3

Words = Sequence[tuple[str, float, float]]
"""Words, each with its start and end in seconds."""


@dataclass(frozen=True)
class TimeMap:
    """A map between the times of two recordings: ``old`` seconds at ``new`` ones, both rising; linear beyond its ends."""

    new: np.ndarray
    old: np.ndarray

    def back(self, times: ArrayLike) -> np.ndarray:
        """Return the times in the old recording that correspond to ``times`` in the new one."""
        return _map(times, self.new, self.old)

    def there(self, times: ArrayLike) -> np.ndarray:
        """Return the times in the new recording that correspond to ``times`` in the old one."""
        return _map(times, self.old, self.new)


def _map(times: ArrayLike, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Interpolate ``y`` over ``x`` at ``times``, with slope 1 beyond the ends."""
    times = np.asarray(times, float)
    return np.interp(times, x, y) + np.minimum(times - x[0], 0) + np.maximum(times - x[-1], 0)


def matching_words(old: Words, new: Words) -> list[tuple[int, int]]:
    """Return pairs of indices of the words that both recordings have, in order."""
    sides = [[normalize_word(word) for word, *_ in words] for words in (old, new)]
    blocks = difflib.SequenceMatcher(None, *sides, autojunk=False).get_matching_blocks()
    return [(block.a + step, block.b + step) for block in blocks for step in range(block.size)]


def align_words(old: Words, new: Words) -> TimeMap:
    """Align a recording with another one of the same or nearly the same words.

    Raises :class:`UsageError` where less than half of the words are the same."""
    pairs = matching_words(old, new)
    if len(pairs) < max(2, _MIN_COMMON * max(len(old), len(new))):
        remedy = "Name the transcript of the new one with --transcript, or make a new take."
        raise UsageError(f"The recordings have only {len(pairs)} words in common, of {len(old)} and {len(new)}.", remedy)
    middles = np.array([[sum(old[a][1:]) / 2, sum(new[b][1:]) / 2] for a, b in pairs])
    rising = np.ones(len(middles), bool)
    rising[1:] = (middles[1:] - np.maximum.accumulate(middles)[:-1] > _MIN_STEP).all(1)
    before, after = middles[rising].T
    near = _TOLERANCE * _tempo(after, before)
    ahead = _taut(after, before - after, near)
    times = np.arange(after[0] - 1, after[-1] + 1 + _STEP, _STEP)
    straight = np.interp(times, after, ahead)
    for seconds in _SMOOTHING:
        smooth = gaussian(straight, seconds / _STEP)
        if (np.abs(np.interp(after, times, smooth) - (before - after)) <= 2 * near).all():
            break
    return TimeMap(times, times + smooth)


def unsaid_edits(edits: Sequence[dict], old: Words, new: Words) -> list[str]:
    """Return a sentence for each edit about a word of the ``old`` recording that the ``new`` one does not say."""
    said, told = {number for number, _ in matching_words(old, new)}, []
    plain = [normalize_word(word) for word, *_ in old]
    for edit in active(edits):
        if "word" in edit:
            places = [number for number, word in enumerate(plain) if word == edit["word"].lower()]
            about = places[edit.get("nth", 1) - 1 :][:1]
        else:
            times = edit["at"] if isinstance(edit.get("at"), list) else [edit["at"]] if "at" in edit else []
            about = [number for number, (_, start, end) in enumerate(old) if any(start <= at <= end for at in times)]
        lost = [old[number][0] for number in about if number not in said]
        if lost and edit["do"] not in TURNS:
            told.append(f"The new recording does not say “{lost[0]}”, which an edit ({edit['do']}) is about.")
    return told


def _tempo(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the tempo of the old recording relative to the new one at each word ``(n,)``, at most 1."""
    steps = np.diff(before) / np.diff(after)
    either = np.minimum(np.append(steps, np.inf), np.insert(steps, 0, np.inf))
    return np.clip(either, _MIN_TEMPO, 1)


def _taut(times: np.ndarray, ahead: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return the taut string ``(n,)`` through the band of width ``near`` around ``ahead``, with free ends.

    Of all curves in the band it changes least, so that neither the fastest nor the slowest tempo is more extreme than needed.
    """
    if len(times) < 3:
        return ahead
    weight = 1 / np.diff(times)
    left, right = np.insert(weight, 0, 0), np.append(weight, 0)
    value = ahead.copy()
    for turn in range(_ITERATIONS):
        rows = slice(turn % 2, None, 2)
        pulled = left * np.roll(value, 1) + right * np.roll(value, -1)
        value[rows] = np.clip(pulled / (left + right), ahead - near, ahead + near)[rows]
    return value
