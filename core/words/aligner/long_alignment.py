"""Aligns a text with a recording of any length, in pieces of some 20 s cut at pauses, with bounded memory.

The number of words in a piece is unknown, so its grammar is a chain of more words than can fit, in which every word may be the
last: the search itself finds where the piece ends in the text. The last seconds of a piece are decoded again at the start of
the next, from the last pause that is safely inside.

A search always finds some path, so each run of eight words must score like speech. If one does not, text and sound diverge:
the words before it are kept, and the sound from there on is recognised, piece by piece, with the text ahead as the only
grammar, until it agrees with a place in the text. Alignment continues there; skipped words are tried in the sound between and
stay without times if they do not fit."""

from collections.abc import Callable, Iterable, Sequence

from .search import Piece, Searcher

PIECE_SECONDS = 20.0
MAX_PIECE_SECONDS = 30.0
"""Seconds: usual and maximum duration that is aligned at once."""
_FIRST_PIECE = 16.0
"""Seconds of a piece as long as nothing has fitted, so that a text that does not fit is noticed soon."""
_MARGIN = 2.0
"""Seconds at the end of a piece that are decoded again with the next."""
_MAX_WORDS_PER_SECOND = 6.0
_PROBE = 15.0
_REACH = 400
_REACH_STEP = 150
_MAX_REACH = 4000
"""Recovery: seconds per trial, words ahead that the first trial considers, how many more each later one does, the most."""
_PATIENCE = (60.0, 900.0)
"""Seconds of recognition before giving up: if nothing was ever found, and otherwise."""
_AGREEING_PAIRS, _WINDOW, _MAX_SHIFT = 4, 9, 2
"""Number of neighbouring word pairs that must agree, within how many in a row, and by how many places they may be shifted."""
_MAX_BRIDGE_SECONDS = 60.0
"""Skipped words are only tried in shorter stretches of sound."""


class LongAligner:
    """Aligns a text between two times in seconds; :attr:`listing` holds ``(start, end, confidence, phones)`` or None per word.

    ``tell`` is called with the time reached so far."""

    def __init__(
        self, searcher: Searcher, words: list[str], start: float, end: float,
        tell: Callable[[float], object] = lambda time: None
    ):  # fmt: skip
        self._searcher, self._words, self._end, self._tell = searcher, words, end, tell
        self._time, self._word, self._look_from = start, 0, start
        self._patience = _PATIENCE[0]
        self.found: list = [None] * len(words)

    def run(self) -> list:
        """Align the whole text; return :attr:`listing`."""
        while self._word < len(self._words) and self._end - self._time > 0.1:
            self._tell(self._time)
            if not self._align_piece() and not self._recover():
                break
        return self.found

    def _align_piece(self) -> bool:
        """Align the next piece; return False if text and sound diverge in it."""
        ever = any(self.found)
        end = choose_cut(self._time, self._end, self._searcher.pauses, PIECE_SECONDS if ever else _FIRST_PIECE)
        final, rest = end == self._end, self._words[self._word :]
        most = int((end - self._time) * _MAX_WORDS_PER_SECOND) + 1
        piece = None
        if final and len(rest) <= most:
            piece = self._searcher.chain(self._time, end, rest)
        if piece is None or piece.good < len(rest):
            opened = self._searcher.chain(self._time, end, rest[:most], open_end=True) if len(rest) > 1 else None
            piece = max((part for part in (piece, opened) if part is not None), key=lambda part: part.good, default=None)
        if piece is None:
            return False
        fits, kept = piece.good == len(piece.spans), piece.good
        if fits and not (final and kept == len(rest)):
            kept = _safe_count(piece.spans, end - _MARGIN)
        return self._keep(piece, kept) and fits

    def _keep(self, piece: Piece, kept: int) -> bool:
        """Store the first words of a piece and continue after them; return whether there were any."""
        if not kept:
            return False
        self._note(self._word, piece, range(kept))
        stop = piece.spans[kept - 1][1]
        following = piece.spans[kept][0] if kept < len(piece.spans) else stop
        self._word, self._time = self._word + kept, (stop + following) / 2
        self._look_from, self._patience = self._time, _PATIENCE[1]
        return True

    def _note(self, word: int, piece: Piece, places: Iterable[int]) -> None:
        """Store some words of a piece whose first word has the number ``word``."""
        for place in places:
            sure = self._searcher.confidence(piece.scores[place])
            self.found[word + place] = (*piece.spans[place], sure, piece.phones[place])

    def _recover(self) -> bool:
        """Recognise the sound to find the place in the text where alignment can continue; return False if there is none."""
        start, reach = max(self._look_from, self._time), _REACH
        while self._patience > 0 and self._end - start > 1.0 and len(self._words) - self._word >= 2:
            self._tell(start)
            end = choose_cut(start, self._end, self._searcher.pauses, _PROBE)
            self._patience -= end - start
            ahead = self._words[self._word : self._word + reach]
            place = find_agreement(self._searcher.recognise(start, end, ahead), ahead)
            if place is not None:
                word, time, until = self._word + place[0], max(place[1] - 0.05, self._time), place[2]
                self._bridge(word, time)
                # if alignment fails here at once, the next recovery starts after the agreement
                self._word, self._time, self._look_from = word, time, until
                return True
            start, reach = end, min(reach + _REACH_STEP, _MAX_REACH)
        return False

    def _bridge(self, word: int, time: float) -> None:
        """Align the skipped words before ``word`` in the sound before ``time``, all or the first of them; store what fits."""
        count, seconds = word - self._word, time - self._time
        if not count or not 0.2 < seconds < _MAX_BRIDGE_SECONDS:
            return
        words = self._words[self._word : word]
        candidates = []
        if count <= _MAX_WORDS_PER_SECOND * seconds:
            candidates.append(self._searcher.chain(self._time, time, words))
        candidates.append(self._searcher.chain(self._time, time, words, open_end=True) if count > 1 else None)
        best, fitting = None, []
        for piece in candidates:
            good = self._searcher.fitting(piece) if piece else []
            if len(good) > len(fitting):
                best, fitting = piece, good
        if best is not None:
            self._note(self._word, best, fitting)


def choose_cut(time: float, end: float, pauses: Sequence[tuple[float, float]], length: float) -> float:
    """Return the middle of the longest pause about ``length`` seconds after ``time``, or ``end`` if that is close."""
    if end - time <= MAX_PIECE_SECONDS * length / PIECE_SECONDS:
        return end
    near = [(high - low, (low + high) / 2) for low, high in pauses if abs((low + high) / 2 - time - length) < length / 4]
    return max(near)[1] if near else time + length


def find_agreement(heard: list[tuple[str, float]], words: list[str]) -> tuple[int, float, float] | None:
    """Find where recognised ``heard`` ``(word, time)`` agree with the text ``words``.

    Returns the number of the first word, its time, and the time where the agreement ends, or None."""
    places: dict[tuple[str, str], list[int]] = {}
    for place, pair in enumerate(zip(words, words[1:], strict=False)):
        places.setdefault(pair, []).append(place)
    pairs = [(here, there) for here in range(len(heard) - 1) for there in places.get((heard[here][0], heard[here + 1][0]), ())]
    for here, there in pairs:
        agreeing = {
            other
            for other, place in pairs
            if here <= other < here + _WINDOW and place >= there and abs(place - there - other + here) <= _MAX_SHIFT
        }
        if len(agreeing) >= min(_AGREEING_PAIRS, max(len(words) - there - 1, 2)):
            back = _count_misheard(heard, here, there)
            return there - back, heard[here - back][1], heard[max(agreeing) + 1][1]
    return None


def _count_misheard(heard: list[tuple[str, float]], here: int, there: int) -> int:
    """Return how many words before the agreement, at most two, directly precede it and were probably misrecognised."""
    back = 0
    while back < min(2, here, there) and heard[here - back][1] - heard[here - back - 1][1] < 0.6:
        back += 1
    return back


def _safe_count(spans: Sequence[tuple[float, float]], before: float) -> int:
    """Return how many words to keep: up to the last audible gap before the time ``before``, at least half of them."""
    gaps = [
        place
        for place in range(max(1, len(spans) // 2), len(spans))
        if spans[place][0] - spans[place - 1][1] >= 0.1 and spans[place - 1][1] <= before
    ]
    return gaps[-1] if gaps else max(1, len(spans) * 3 // 4)
