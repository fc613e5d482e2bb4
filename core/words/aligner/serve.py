"""The program's protocol, described in this package's docstring."""

import json
import sys
import tempfile

from .engines import engine, make_ready
from .follow import WHOLE, Follower
from .search import Searcher
from .sound import Sound

_SLACK = 0.6
"""Seconds by which subtitles come early or stay on."""


def main() -> None:
    """Answer one request from standard input, for which it may have been started long before; none may ever come."""
    make_ready()
    line = sys.stdin.buffer.readline()
    if not line:
        return
    request = json.loads(line)
    sound = Sound(sys.stdin.buffer, request["samples"])
    vocabulary = {part for stretch in request["stretches"] for parts in stretch["words"] for part in parts}
    spans = []
    with tempfile.TemporaryDirectory(dir=request.get("folder")) as folder:
        searcher = Searcher(sound, request["pauses"], engine(vocabulary, folder, request.get("model")))
        for stretch in request["stretches"]:
            spans += _place(searcher, stretch, lambda time: _tell(progress=round(min(time / sound.duration, 1.0), 3)))
    # what is left of the sound is read, so that its writer does not meet a closed pipe
    while sys.stdin.buffer.read(1 << 20):
        pass
    _tell(spans=spans)


def _tell(**message) -> None:
    print(json.dumps(message), flush=True)


def _place(searcher: Searcher, stretch: dict, tell) -> list:
    """Spans of the words of a stretch: those of their spoken parts, from the first that was found to the last."""
    able = searcher.learn({part for parts in stretch["words"] for part in parts})
    owners = [(owner, part) for owner, parts in enumerate(stretch["words"]) for part in parts if part in able]
    words = [part for _, part in owners]
    spans = [None] * len(stretch["words"])
    for (owner, _), span in zip(owners, _find(searcher, words, stretch["start"], stretch["end"], tell), strict=True):
        if span is not None:
            start, _, sure, phones = spans[owner] or (*span[:3], [])
            spans[owner] = (start, span[1], min(sure, span[2]), phones + span[3])
    return spans


def _find(searcher: Searcher, words: list[str], start: float, end: float, tell) -> list:
    """A short stretch that is not the whole recording is one phrase; all else is followed."""
    whole = start <= 0 and end >= searcher.sound.duration
    if not words:
        return []
    if whole or end - start > WHOLE:
        return Follower(searcher, words, start, end, tell).run()
    tell(start)
    early, late = max(start - _SLACK, 0.0), min(end + _SLACK, searcher.sound.duration)
    pieces = [searcher.chain(early, late, words)]
    if pieces[0] is None or pieces[0].good < len(words):
        pieces.append(searcher.chain(start, end, words))
    piece = max((piece for piece in pieces if piece is not None), key=lambda piece: piece.good, default=None)
    if piece is None:
        return [None] * len(words)
    spans: list = [None] * len(words)
    for place in searcher.fitting(piece):
        spans[place] = (*piece.spans[place], searcher.confidence(piece.scores[place]), piece.phones[place])
    return spans
