"""Selects the turns of one speaker in a transcript with speaker labels, as in ``ANNA: That is what I mean.``"""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike

import numpy as np

from ..errors import UsageError
from ..motion.interpolation import true_runs
from . import markup
from .transcript import TimedTranscript, read_text

_NAMES = 'Write names in capitals before what is said, as in "ANNA: Hello."'
_MARGIN_SECONDS = 0.25
"""A turn extends this far beyond its words, unless somebody else speaks there."""


def words_of_speaker(
    said: TimedTranscript, file: str | PathLike | None, text: str | None, who: str
) -> tuple[TimedTranscript, np.ndarray]:
    """Return the words of the speaker ``who``, and the turns ``(n, 2)`` of that speaker in seconds.

    ``said`` are the aligned words of the plain ``text``, or of a ``file``. Raises :class:`UsageError` if neither is given, the
    text has no such speaker or its words do not match ``said``."""
    if text is None and file is None:
        raise UsageError("Turns need a transcript with names.", _NAMES)
    text = read_text(file) if text is None and file is not None else text or ""
    pieces = markup.split_speakers(text)
    names = list(dict.fromkeys(name for name, _ in pieces if name))
    if who.casefold() not in {name.casefold() for name in names}:
        raise UsageError(f"The transcript names no {who}.", f"Names are {', '.join(names)}." if names else _NAMES)
    speaker = [name.casefold() for name, piece in pieces for _ in markup.parse(piece).tokens]
    if len(speaker) != len(said.words):
        raise UsageError("Whose words are whose cannot be told.", "Give a plain text with names before its lines.")
    mine = np.array([name == who.casefold() for name in speaker])
    marks = tuple(
        _renumber(mark, np.cumsum(mine) - 1) for mark in said.marks if mine[mark.first : max(mark.last, mark.first + 1)].all()
    )
    own_values = {name: tuple(value for value, is_own in zip(getattr(said, name), mine, strict=False) if is_own)
                  for name in ("words", "confidence", "phones", "written")}  # fmt: skip
    return replace(said, **own_values, marks=marks), _turns(said.words, mine)


def _renumber(mark: markup.Mark, number: np.ndarray) -> markup.Mark:
    """Return the mark with its word numbers replaced by those in ``number`` ``(n,)``."""
    first = int(number[mark.first])
    return replace(mark, first=first, last=first + mark.last - mark.first)


def _turns(words: Sequence[tuple[str, float, float]], mine: np.ndarray) -> np.ndarray:
    """Return turns ``(n, 2)`` in seconds: runs of words where ``mine`` is true, extended by a margin on both sides."""
    spans = []
    for first, last in true_runs(mine).tolist():
        start, end = words[first][1], words[last - 1][2]
        before = 0.5 * (words[first - 1][2] + start) if first else 0.0
        after = 0.5 * (words[last][1] + end) if last < len(words) else np.inf
        spans.append((max(start - _MARGIN_SECONDS, before), min(end + _MARGIN_SECONDS, after)))
    return np.array(spans).reshape(-1, 2)
