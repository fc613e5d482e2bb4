"""Words of a text along a recording of any length, in pieces of some 20 s cut at pauses, with bounded memory.

How many words belong to a piece is not known, so its grammar is a chain of more words than fit in which every word may be
the last: the search itself finds where the piece ends in the text. The last seconds of a piece are decoded again at the
start of the next, from the last pause that is safely inside.

A search always finds some path, so each run of eight words must score like speech. Where one does not, text and sound have
parted: the words before it are kept, and what is said from there on is recognised, piece by piece, with the text ahead as
the only grammar, until it agrees with a place in the text. Following goes on there; words that were jumped over are tried
in the sound between and stay without a place where they do not fit.
"""

from .search import Piece, Searcher

PIECE = 20.0
WHOLE = 30.0
"""Seconds: at most this much is followed in one go."""
_FIRST = 16.0
"""Seconds of a piece before anything has fitted: a text that does not fit is noticed soon."""
_MARGIN = 2.0
_FASTEST = 6.0
"""Spoken words a second: an upper bound on what a piece can hold."""
_PROBE = 15.0
_REACH = 400
_REACH_MORE = 150
_FARTHEST = 4000
"""When lost: seconds of a trial, words ahead in which the first looks, how many more each later one, and the most."""
_PATIENCE = (60.0, 900.0)
"""Seconds recognised before giving up: when nothing was ever found, and else."""
_AGREEING, _WITHIN, _SLIP = 4, 9, 2
"""So many pairs of neighbouring words must agree, among so many in a row, give or take so many places."""
_BRIDGE = 60.0
"""Seconds between two places in which words that were jumped over are tried."""


class Follower:
    """A text on its way through the sound between two moments; :attr:`found` has ``(start, end, confidence,
    phones)`` or None."""

    def __init__(self, searcher: Searcher, words: list[str], start: float, end: float, tell=lambda time: None):
        self._searcher, self._words, self._end, self._tell = searcher, words, end, tell
        self._time, self._word, self._look_from = start, 0, start
        self._patience = _PATIENCE[0]
        self.found: list = [None] * len(words)

    def run(self) -> list:
        """:attr:`found` when all is done."""
        while self._word < len(self._words) and self._end - self._time > 0.1:
            self._tell(self._time)
            if not self._advance() and not self._search():
                break
        return self.found

    def _advance(self) -> bool:
        """Follow the text over the next piece; False if it parted from the sound."""
        ever = any(self.found)
        end = cut(self._time, self._end, self._searcher.pauses, PIECE if ever else _FIRST)
        final, rest = end == self._end, self._words[self._word :]
        most = int((end - self._time) * _FASTEST) + 1
        piece = None
        if final and len(rest) <= most:
            piece = self._searcher.chain(self._time, end, rest)
        if piece is None or piece.good < len(rest):
            opened = self._searcher.chain(self._time, end, rest[:most], open_end=True) if len(rest) > 1 else None
            piece = max((part for part in (piece, opened) if part is not None), key=lambda part: part.good, default=None)
        fits = piece is not None and piece.good == len(piece.spans)
        kept = 0 if piece is None else piece.good
        if fits and not (final and kept == len(rest)):
            kept = _safe(piece.spans, end - _MARGIN)
        return self._keep(piece, kept) and fits

    def _keep(self, piece: Piece | None, kept: int) -> bool:
        """Note the first words of a piece and go on behind them; whether there were any."""
        if not kept:
            return False
        self._note(self._word, piece, range(kept))
        stop = piece.spans[kept - 1][1]
        following = piece.spans[kept][0] if kept < len(piece.spans) else stop
        self._word, self._time = self._word + kept, (stop + following) / 2
        self._look_from, self._patience = self._time, _PATIENCE[1]
        return True

    def _note(self, word: int, piece: Piece, places) -> None:
        for place in places:
            sure = self._searcher.confidence(piece.scores[place])
            self.found[word + place] = (*piece.spans[place], sure, piece.phones[place])

    def _search(self) -> bool:
        """Lost: find where in the text what is said next stands, and go on there; False if that cannot be told."""
        start, reach = max(self._look_from, self._time), _REACH
        while self._patience > 0 and self._end - start > 1.0 and len(self._words) - self._word >= 2:
            self._tell(start)
            end = cut(start, self._end, self._searcher.pauses, _PROBE)
            self._patience -= end - start
            ahead = self._words[self._word : self._word + reach]
            place = agreement(self._searcher.recognise(start, end, ahead), ahead)
            if place is not None:
                word, time, until = self._word + place[0], max(place[1] - 0.05, self._time), place[2]
                self._bridge(word, time)
                # where following from here fails at once, the next search begins behind it
                self._word, self._time, self._look_from = word, time, until
                return True
            start, reach = end, min(reach + _REACH_MORE, _FARTHEST)
        return False

    def _bridge(self, word: int, time: float) -> None:
        """Try the words before ``word`` in the sound before ``time``, all and the first of them; what fits is noted."""
        count, seconds = word - self._word, time - self._time
        if not count or not 0.2 < seconds < _BRIDGE:
            return
        words = self._words[self._word : word]
        tried = []
        if count <= _FASTEST * seconds:
            tried.append(self._searcher.chain(self._time, time, words))
        tried.append(self._searcher.chain(self._time, time, words, open_end=True) if count > 1 else None)
        best, fitting = None, []
        for piece in tried:
            good = self._searcher.fitting(piece) if piece else []
            if len(good) > len(fitting):
                best, fitting = piece, good
        self._note(self._word, best, fitting)


def cut(time: float, end: float, pauses: list, length: float) -> float:
    """The middle of the longest pause about ``length`` on, or ``end`` when that is not far."""
    if end - time <= WHOLE * length / PIECE:
        return end
    near = [(high - low, (low + high) / 2) for low, high in pauses if abs((low + high) / 2 - time - length) < length / 4]
    return max(near)[1] if near else time + length


def agreement(heard: list[tuple[str, float]], words: list[str]) -> tuple[int, float, float] | None:
    """Where ``heard`` (word, time) agrees with the text: the first place, its time, and when the agreement ends; or None."""
    places: dict[tuple[str, str], list[int]] = {}
    for place, pair in enumerate(zip(words, words[1:], strict=False)):
        places.setdefault(pair, []).append(place)
    pairs = [(here, there) for here in range(len(heard) - 1) for there in places.get((heard[here][0], heard[here + 1][0]), ())]
    for here, there in pairs:
        with_it = {
            other
            for other, place in pairs
            if here <= other < here + _WITHIN and place >= there and abs(place - there - other + here) <= _SLIP
        }
        if len(with_it) >= min(_AGREEING, max(len(words) - there - 1, 2)):
            back = _before(heard, here, there)
            return there - back, heard[here - back][1], heard[max(with_it) + 1][1]
    return None


def _before(heard: list[tuple[str, float]], here: int, there: int) -> int:
    """Up to two words in front that were likely misheard: said without a gap."""
    back = 0
    while back < min(2, here, there) and heard[here - back][1] - heard[here - back - 1][1] < 0.6:
        back += 1
    return back


def _safe(spans: list, before: float) -> int:
    """How many words to keep: up to the last audible gap ahead of ``before``, at least half of them."""
    gaps = [
        place
        for place in range(max(1, len(spans) // 2), len(spans))
        if spans[place][0] - spans[place - 1][1] >= 0.1 and spans[place - 1][1] <= before
    ]
    return gaps[-1] if gaps else max(1, len(spans) * 3 // 4)
