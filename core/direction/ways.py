"""The way from the times of one recording to those of another of the same words.

It is the straightest that comes near enough to all words that both have, so that tempo changes no more than it must; and
then as smooth as these words let it be.
"""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..smoothing import gaussian
from .gestures import spoken

_NEAR, _LEAST = 0.03, 0.2
"""Seconds that the way may pass a word by, and the share of them that is left where the new recording is slower."""
_SMOOTH = (0.2, 0.12, 0.08, 0.05, 0.03, 0.02)
"""Seconds over which tempo changes: the first of these that leads by all words within twice as much."""
_SHARE = 0.5
"""Share of the words of both recordings that must be the same."""
_STEP = 0.01
_TURNS = 400
_APART = 1e-3

Words = Sequence[tuple[str, float, float]]
"""What is said, each with the seconds of its start and end."""


@dataclass(frozen=True)
class Way:
    """Seconds of the ``old`` recording at those of the ``new`` one, both rising; beyond its ends they go on side by side."""

    new: np.ndarray
    old: np.ndarray

    def back(self, times) -> np.ndarray:
        """Seconds of the old recording at those of the new one."""
        return _along(times, self.new, self.old)

    def there(self, times) -> np.ndarray:
        """Seconds of the new recording at those of the old one."""
        return _along(times, self.old, self.new)


def _along(times, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    times = np.asarray(times, float)
    return np.interp(times, x, y) + np.minimum(times - x[0], 0) + np.maximum(times - x[-1], 0)


def matched(old: Words, new: Words) -> list[tuple[int, int]]:
    """Numbers of the words that both recordings have, in order."""
    sides = [[spoken(word) for word, *_ in words] for words in (old, new)]
    blocks = difflib.SequenceMatcher(None, *sides, autojunk=False).get_matching_blocks()
    return [(block.a + step, block.b + step) for block in blocks for step in range(block.size)]


def way(old: Words, new: Words) -> Way:
    """The way from the times of a recording to those of another that says the same, or nearly.

    Raises :class:`UsageError` where less than half of the words are the same.
    """
    pairs = matched(old, new)
    if len(pairs) < max(2, _SHARE * max(len(old), len(new))):
        remedy = "Name the transcript of the new one with --transcript, or make a new take."
        raise UsageError(f"The recordings have only {len(pairs)} words in common, of {len(old)} and {len(new)}.", remedy)
    middles = np.array([[sum(old[one][1:]) / 2, sum(new[other][1:]) / 2] for one, other in pairs])
    later = np.ones(len(middles), bool)
    later[1:] = (middles[1:] - np.maximum.accumulate(middles)[:-1] > _APART).all(1)
    before, after = middles[later].T
    near = _NEAR * _tempo(after, before)
    ahead = _taut(after, before - after, near)
    times = np.arange(after[0] - 1, after[-1] + 1 + _STEP, _STEP)
    straight = np.interp(times, after, ahead)
    for seconds in _SMOOTH:
        even = gaussian(straight, seconds / _STEP)
        if (np.abs(np.interp(after, times, even) - (before - after)) <= 2 * near).all():
            break
    return Way(times, times + even)


def _tempo(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """How fast the old recording passes at each word ``(n,)``, 1 at most."""
    steps = np.diff(before) / np.diff(after)
    either = np.minimum(np.append(steps, np.inf), np.insert(steps, 0, np.inf))
    return np.clip(either, _LEAST, 1)


def _taut(times: np.ndarray, ahead: np.ndarray, near: np.ndarray) -> np.ndarray:
    """A string ``(n,)`` pulled straight past ``ahead``, never farther than ``near`` from it, with free ends.

    Of all that stay so near it changes least: neither the fastest nor the slowest tempo is more than is needed.
    """
    if len(times) < 3:
        return ahead
    weight = 1 / np.diff(times)
    left, right = np.insert(weight, 0, 0), np.append(weight, 0)
    value = ahead.copy()
    for turn in range(_TURNS):
        rows = slice(turn % 2, None, 2)
        pulled = left * np.roll(value, 1) + right * np.roll(value, -1)
        value[rows] = np.clip(pulled / (left + right), ahead - near, ahead + near)[rows]
    return value
