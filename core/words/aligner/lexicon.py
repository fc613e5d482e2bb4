"""Looks up pronunciations: in a dictionary, from eSpeak NG for other languages, otherwise by letter rules."""

from collections.abc import Iterator
from io import TextIOWrapper
from os import PathLike
from typing import TextIO

from ...files import open_file
from . import packed_model
from .letter_rules import guess_phones

_MAX_PRONUNCIATIONS, _MAX_LINE_LENGTH = 16, 1000
"""Per word, and in characters; what is beyond is ignored."""


class Lexicon:
    """Pronunciations, phones separated by spaces, of the words in a ``vocabulary``; other words are not looked up.

    English words come from :mod:`packed_model`. A ``model`` of another language (:mod:`..language`) has its own dictionary,
    voice of eSpeak NG and letter rules, and uses no English words."""

    def __init__(self, vocabulary: set[str], model: dict | None = None):
        self._model = model or {}
        self._ways: dict[str, list[str]] = {}
        words = vocabulary | {word.lower() for word in vocabulary}
        if not self._model:
            self._ways = packed_model.pronunciations(words)
        elif self._model.get("dictionary"):
            self._look_up(self._model["dictionary"], words)
        if self._model.get("voice"):
            from .espeak import Espeak  # only where it is installed; the extension's zip leaves it out

            espeak = Espeak(self._model["voice"])
            self._ways.update(
                {word: ways for word in sorted(words - self._ways.keys()) if (ways := espeak.pronunciations(word))}
            )

    def _look_up(self, dictionary: str | PathLike, words: set[str]) -> None:
        """Read the pronunciations of these words from a dictionary file."""
        with open_file(dictionary) as file, TextIOWrapper(file, "utf-8", "replace") as lines:
            for line in _beginnings(lines):
                parts = line.split(None, 1)
                if len(parts) == 2 and (word := parts[0].partition("(")[0]) in words:
                    ways = self._ways.setdefault(word, [])
                    if len(ways) < _MAX_PRONUNCIATIONS:
                        ways.append(parts[1].strip())

    def known(self) -> dict[str, list[str]]:
        """Return the pronunciations of all words that were found."""
        return self._ways

    def ways(self, word: str) -> list[str]:
        """Return the pronunciations of a word as written, else the first one in lower case, else a guess, if possible."""
        entries = self._ways.get(word) or self._ways.get(word.lower(), [])[:1]
        guess = "" if entries else guess_phones(word, self._model.get("letters"))
        return entries or ([guess] if guess.strip() else [])


def _beginnings(file: TextIO) -> Iterator[str]:
    """Yield the lines of a file, long ones truncated."""
    whole = True
    while piece := file.readline(_MAX_LINE_LENGTH):
        if whole:
            yield piece
        whole = piece.endswith("\n")
