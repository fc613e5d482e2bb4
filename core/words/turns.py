"""Who says what in a transcript with names at the beginnings of its lines, as in ``ANNA: That is what I mean.``"""

from dataclasses import replace

import numpy as np

from ..errors import UsageError
from . import markup
from .transcript import Heard

_ROOM = 0.25
"""Seconds around what somebody says that are theirs, where nobody else speaks."""


def own(said: Heard, text: str, who: str) -> tuple[Heard, np.ndarray]:
    """What ``who`` says of a plain ``text`` that was heard as ``said``, and the seconds of their turns ``(n, 2)``.

    Raises :class:`UsageError` where the text names nobody of that name, or no words of it are known.
    """
    pieces = markup.lines(text)
    names = list(dict.fromkeys(name for name, _ in pieces if name))
    if who.casefold() not in {name.casefold() for name in names}:
        listed = (
            f"Names are {', '.join(names)}." if names else 'Write names in capitals before what is said, as in "ANNA: Hello."'
        )
        raise UsageError(f"The transcript names no {who}.", listed)
    speaker = [name.casefold() for name, piece in pieces for _ in markup.read(piece).tokens]
    if len(speaker) != len(said.words):
        raise UsageError("Whose words are whose cannot be told.", "Give a plain text with names before its lines.")
    mine = np.array([name == who.casefold() for name in speaker])
    marks = tuple(
        _counted(mark, np.cumsum(mine) - 1) for mark in said.marks if mine[mark.first : max(mark.last, mark.first + 1)].all()
    )
    kept = {name: tuple(one for one, own in zip(getattr(said, name), mine, strict=False) if own)
            for name in ("words", "confidence", "phones")}  # fmt: skip
    return replace(said, **kept, marks=marks), _turns(said.words, mine)


def _counted(mark: markup.Mark, number: np.ndarray) -> markup.Mark:
    """A mark that counts the words of one speaker, ``number`` of all words ``(n,)``."""
    first = int(number[mark.first])
    return replace(mark, first=first, last=first + mark.last - mark.first)


def _turns(words, mine: np.ndarray) -> np.ndarray:
    """Seconds ``(n, 2)`` from the first to the last word of each turn, and a little around as far as nobody else speaks."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mine, [0]]).astype(int))).reshape(-1, 2)
    spans = []
    for first, last in edges.tolist():
        start, end = words[first][1], words[last - 1][2]
        before = 0.5 * (words[first - 1][2] + start) if first else 0.0
        after = 0.5 * (words[last][1] + end) if last < len(words) else np.inf
        spans.append((max(start - _ROOM, before), min(end + _ROOM, after)))
    return np.array(spans).reshape(-1, 2)
