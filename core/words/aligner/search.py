"""The search in a piece of sound: which treatment of the sound works, and which of the words found sound like their words."""

from typing import NamedTuple

import numpy as np

from .sound import RATE, Sound, treated

RUN = 8
"""Words in a row that are judged together."""
_LADDERS = 2
"""How often all attempts are made before anything has ever fitted; a text that does not fit costs no more."""


class Piece(NamedTuple):
    """Words found in a row: ``(start, end)`` in seconds, mean log10 scores a frame, how many of them sound like their words,
    and the ``phones`` of each, ``[name, start, end]``, none where the engine tells none."""

    spans: list
    scores: np.ndarray
    good: int
    phones: list


class Searcher:
    """One recording, and the kind of search that works on it; ``engine`` is an :class:`ear.Ear` or a :class:`sphinx.Sphinx`."""

    def __init__(self, sound: Sound, pauses: list, engine):
        self.sound, self.pauses, self._engine = sound, pauses, engine
        self._kind, self._ladders = None, _LADDERS
        self._treated: tuple = (None, None)
        self.usual = -9.0

    def learn(self, words: set[str]) -> set[str]:
        """Those of the words that can be said."""
        return self._engine.learn(words)

    def chain(self, start: float, end: float, words: list[str], open_end: bool = False) -> Piece | None:
        """All words between two moments, or with ``open_end`` the first few of them; None without a path.

        Until a kind of search has worked on this recording several are tried, and the best counts.
        """
        if self.sound.count(start, end) < RATE // 10 or not words:
            return None
        every = self._engine.attempts
        attempts = [self._kind] if self._kind else every if self._ladders else every[:1]
        others = [one for one in self._engine.strange if one not in attempts]
        self._ladders -= not self._kind and self._ladders > 0
        best = kind = None
        for treatment, wide in [*attempts, *others]:
            if best is not None and (treatment, wide) in others:
                break
            found = self._engine.chain(self._sound(start, end, treatment), words, open_end, wide)
            piece = self._judged(found) if found else None
            if piece is not None and (best is None or piece.good > best.good):
                best, kind = piece, (treatment, wide)
                if piece.good == len(piece.spans):
                    break
        if best is None:
            return None
        if best.good >= min(RUN, len(words)):
            self._kind = kind
        phones = [[[name, round(start + begin, 3), round(start + stop, 3)] for name, begin, stop in one] for one in best.phones]
        return Piece([(start + begin, start + stop) for begin, stop in best.spans], best.scores, best.good, phones)

    def fitting(self, piece: Piece) -> list[int]:
        """Places of the words that sound right, as far as this recording has told, or stand alone among such."""
        engine = self._engine
        right = piece.scores >= max(engine.worst, self.usual - engine.drop) - engine.slack
        among = np.pad(right, 1, constant_values=True)
        return np.flatnonzero(right | (among[:-2] & among[2:] & right.any())).tolist()

    def confidence(self, score: float) -> float:
        """0..1 from a score and what is usual in this recording: how surely a word lies where it was found."""
        return float(np.clip(1 + (score - self.usual) / self._engine.spread, 0.05, 1.0))

    def recognise(self, start: float, end: float, words: list[str]) -> list[tuple[str, float]]:
        """What seems to be said, ``(word, start)`` in seconds, in words of the text and mostly in its order."""
        treatment = (self._kind or self._engine.attempts[0])[0]
        return [(word, start + begin) for word, begin in self._engine.recognise(self._sound(start, end, treatment), words)]

    def _sound(self, start: float, end: float, treatment: str) -> np.ndarray:
        """The treated sound between two moments: the same array if it is the same as the last time."""
        asked = start, end, treatment
        if self._treated[0] != asked:
            pauses = [
                (max(low, start) - start, min(high, end) - start) for low, high in self.pauses if low < end and high > start
            ]
            self._treated = asked, treated(self.sound.cut(start, end), treatment, pauses)
        return self._treated[1]

    def _judged(self, found: list[tuple]) -> Piece:
        """How many of the first words sound like their words, in runs of :data:`RUN`."""
        lengths = np.array([100 * (stop - begin) for begin, stop, *_ in found])
        totals = np.array([total for _, _, total, _ in found])
        runs = means(totals, lengths, RUN)
        usual = max(self.usual, float(np.percentile(runs, 75)))
        bad = np.flatnonzero(runs < max(self._engine.worst, usual - self._engine.drop))
        if not len(bad):
            self.usual = usual
        good = len(found) if not len(bad) else int(bad[0]) + RUN // 4 if bad[0] else 0
        spans, phones = [span[:2] for span in found], [span[3] for span in found]
        return Piece(spans, around(totals, lengths), min(good, len(found)), phones)


def means(totals: np.ndarray, lengths: np.ndarray, size: int) -> np.ndarray:
    """Mean score a frame of every ``size`` words in a row (of all where there are fewer)."""
    size = min(size, len(totals))
    total, length = (np.concatenate([[0.0], np.cumsum(part)]) for part in (totals, lengths))
    return (total[size:] - total[:-size]) / (length[size:] - length[:-size])


def around(totals: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Mean score a frame of every word and its neighbours."""
    total, length = (np.convolve(part, np.ones(3), mode="same") for part in (totals, lengths))
    return total / length if len(totals) > 2 else np.full(len(totals), totals.sum() / lengths.sum())
