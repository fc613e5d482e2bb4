"""Serves a request by the protocol that the docstring of this package describes."""

import json
import sys
import tempfile
from collections.abc import Callable
from typing import Any

from .engines import create_engine, preload
from .long_alignment import MAX_PIECE_SECONDS, LongAligner
from .search import Searcher
from .sound_stream import SoundStream

_SLACK = 0.6
"""Seconds that subtitles may appear too early or stay too long."""


def main() -> None:
    """Answer one request from standard input; it may come long after the start of the process, or never."""
    preload()
    line = sys.stdin.buffer.readline()
    if not line:
        return
    request = json.loads(line)
    sound = SoundStream(sys.stdin.buffer, request["samples"])
    vocabulary = {part for stretch in request["stretches"] for parts in stretch["words"] for part in parts}
    spans = []
    with tempfile.TemporaryDirectory(dir=request.get("folder")) as folder:
        searcher = Searcher(sound, request["pauses"], create_engine(vocabulary, folder, request.get("model")))
        for stretch in request["stretches"]:
            spans += _place(searcher, stretch, lambda time: _send(progress=round(min(time / sound.duration, 1.0), 3)))
    # read the rest of the sound, so that its writer does not meet a closed pipe
    while sys.stdin.buffer.read(1 << 20):
        pass
    _send(spans=spans)


def _send(**message: Any) -> None:
    """Write a message to standard output."""
    print(json.dumps(message), flush=True)


def _place(searcher: Searcher, stretch: dict, report: Callable[[float], object]) -> list[tuple | None]:
    """Align a stretch; the span of a word reaches from its first spoken part that was found to its last.

    ``report`` is called with the time reached so far."""
    pronounceable = searcher.learn({part for parts in stretch["words"] for part in parts})
    owners = [(owner, part) for owner, parts in enumerate(stretch["words"]) for part in parts if part in pronounceable]
    words = [part for _, part in owners]
    spans: list[tuple | None] = [None] * len(stretch["words"])
    for (owner, _), span in zip(owners, _find(searcher, words, stretch["start"], stretch["end"], report), strict=True):
        if span is not None:
            start, _, sure, phones = spans[owner] or (*span[:3], [])
            spans[owner] = (start, span[1], min(sure, span[2]), phones + span[3])
    return spans


def _find(
    searcher: Searcher, words: list[str], start: float, end: float, report: Callable[[float], object]
) -> list[tuple | None]:
    """Align spoken words: a short stretch that is not the whole recording at once, all else piece by piece."""
    whole = start <= 0 and end >= searcher.sound.duration
    if not words:
        return []
    if whole or end - start > MAX_PIECE_SECONDS:
        return LongAligner(searcher, words, start, end, report).run()
    report(start)
    early, late = max(start - _SLACK, 0.0), min(end + _SLACK, searcher.sound.duration)
    pieces = [searcher.chain(early, late, words)]
    if pieces[0] is None or pieces[0].good < len(words):
        pieces.append(searcher.chain(start, end, words))
    piece = max((piece for piece in pieces if piece is not None), key=lambda piece: piece.good, default=None)
    if piece is None:
        return [None] * len(words)
    spans: list[tuple | None] = [None] * len(words)
    for place in searcher.fitting(piece):
        spans[place] = (*piece.spans[place], searcher.confidence(piece.scores[place]), piece.phones[place])
    return spans
