"""Aligns words in a piece of sound: finds the treatment of the sound that works, and judges which words really fit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .sound_stream import RATE, SoundStream, preprocess

if TYPE_CHECKING:
    from .numpy_engine import NumpyEngine
    from .sphinx_engine import SphinxEngine

RUN_LENGTH = 8
"""Number of successive words that are judged together."""
_MAX_FULL_TRIALS = 2
"""How often all attempts are made as long as nothing has fitted, so that a text that does not fit costs no more."""


class Piece(NamedTuple):
    """Aligned words: ``spans`` ``(start, end)`` in seconds, mean log10 ``scores`` per frame, how many of the first words fit
    (``good``), and the ``phones`` of each, ``[name, start, end]``, empty if the engine gives none."""

    spans: list
    scores: np.ndarray
    good: int
    phones: list


class Searcher:
    """Searches one recording with an engine, and remembers which attempt (treatment, wide beams) works on it."""

    def __init__(self, sound: SoundStream, pauses: list, engine: "NumpyEngine | SphinxEngine"):
        self.sound, self.pauses, self._engine = sound, pauses, engine
        self._attempt, self._full_trials = None, _MAX_FULL_TRIALS
        self._cached: tuple = (None, None)
        self.usual = -9.0
        """Typical mean score per frame of good words in this recording."""

    def learn(self, words: set[str]) -> set[str]:
        """Return the words that have a pronunciation."""
        return self._engine.learn(words)

    def chain(self, start: float, end: float, words: list[str], open_end: bool = False) -> Piece | None:
        """Align all words between two times in seconds, or with ``open_end`` the first few of them; None without a path.

        Until one attempt has worked on this recording several are made, and the best one counts."""
        if self.sound.count(start, end) < RATE // 10 or not words:
            return None
        every = self._engine.attempts
        attempts = [self._attempt] if self._attempt else every if self._full_trials else every[:1]
        fallbacks = [attempt for attempt in self._engine.fallbacks if attempt not in attempts]
        self._full_trials -= not self._attempt and self._full_trials > 0
        best = best_attempt = None
        for treatment, wide in [*attempts, *fallbacks]:
            if best is not None and (treatment, wide) in fallbacks:
                break
            path = self._engine.chain(self._sound(start, end, treatment), words, open_end, wide)
            piece = self._judge(path) if path else None
            if piece is not None and (best is None or piece.good > best.good):
                best, best_attempt = piece, (treatment, wide)
                if piece.good == len(piece.spans):
                    break
        if best is None:
            return None
        if best.good >= min(RUN_LENGTH, len(words)):
            self._attempt = best_attempt
        phones = [
            [[name, round(start + begin, 3), round(start + stop, 3)] for name, begin, stop in word] for word in best.phones
        ]
        return Piece([(start + begin, start + stop) for begin, stop in best.spans], best.scores, best.good, phones)

    def fitting(self, piece: Piece) -> list[int]:
        """Return the numbers of the words whose score is good for this recording, or whose two neighbours' scores are."""
        engine = self._engine
        right = piece.scores >= max(engine.worst, self.usual - engine.drop) - engine.slack
        among = np.pad(right, 1, constant_values=True)
        return np.flatnonzero(right | (among[:-2] & among[2:] & right.any())).tolist()

    def confidence(self, score: float) -> float:
        """Convert a score to a confidence 0..1, relative to the typical score of this recording."""
        return float(np.clip(1 + (score - self.usual) / self._engine.spread, 0.05, 1.0))

    def recognise(self, start: float, end: float, words: list[str]) -> list[tuple[str, float]]:
        """Recognise ``(word, start)`` in seconds, with the words of the text and mostly in their order."""
        treatment = (self._attempt or self._engine.attempts[0])[0]
        return [(word, start + begin) for word, begin in self._engine.recognise(self._sound(start, end, treatment), words)]

    def _sound(self, start: float, end: float, treatment: str) -> np.ndarray:
        """Return the treated sound between two times in seconds: the same array if it was the last one."""
        key = start, end, treatment
        if self._cached[0] != key:
            pauses = [
                (max(low, start) - start, min(high, end) - start) for low, high in self.pauses if low < end and high > start
            ]
            self._cached = key, preprocess(self.sound.cut(start, end), treatment, pauses)
        return self._cached[1]

    def _judge(self, path: Sequence[tuple]) -> Piece:
        """Count how many of the first words fit, by the scores of runs of :data:`RUN_LENGTH` words."""
        lengths = np.array([100 * (stop - begin) for begin, stop, *_ in path])
        totals = np.array([total for _, _, total, _ in path])
        runs = mean_scores(totals, lengths, RUN_LENGTH)
        usual = max(self.usual, float(np.percentile(runs, 75)))
        bad = np.flatnonzero(runs < max(self._engine.worst, usual - self._engine.drop))
        if not len(bad):
            self.usual = usual
        good = len(path) if not len(bad) else int(bad[0]) + RUN_LENGTH // 4 if bad[0] else 0
        spans, phones = [word[:2] for word in path], [word[3] for word in path]
        return Piece(spans, smoothed_scores(totals, lengths), min(good, len(path)), phones)


def mean_scores(totals: np.ndarray, lengths: np.ndarray, size: int) -> np.ndarray:
    """Return the mean score per frame of every ``size`` words in a row (of all words if there are fewer)."""
    size = min(size, len(totals))
    total, length = (np.concatenate([[0.0], np.cumsum(part)]) for part in (totals, lengths))
    return (total[size:] - total[:-size]) / (length[size:] - length[:-size])


def smoothed_scores(totals: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the mean score per frame of every word with its two neighbours."""
    total, length = (np.convolve(part, np.ones(3), mode="same") for part in (totals, lengths))
    return total / length if len(totals) > 2 else np.full(len(totals), totals.sum() / lengths.sum())
