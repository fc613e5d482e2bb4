"""How words are pronounced: by a dictionary, by eSpeak NG for other languages, and else by their letters."""

from collections.abc import Iterator
from typing import TextIO

from . import packed
from .letters import phones
from .pronounce import Espeak

_WAYS, _LINE = 16, 1000
"""Ways to say a word, and letters of a line with one, that count."""


class Lexicon:
    """Pronunciations, each phones divided by spaces, of a ``vocabulary``; other words are not looked up.

    English words are those of :mod:`packed`. A ``model`` of another language (:mod:`..language`) names its own, the
    voice of eSpeak NG, and rules for letters; English words are none of it.
    """

    def __init__(self, vocabulary: set[str], model: dict | None = None):
        self._model = model or {}
        self._ways: dict[str, list[str]] = {}
        wanted = vocabulary | {word.lower() for word in vocabulary}
        if not self._model:
            self._ways = packed.pronunciations(wanted)
        elif self._model.get("dictionary"):
            self._look_up(self._model["dictionary"], wanted)
        if self._model.get("voice"):
            espeak = Espeak(self._model["voice"])
            self._ways.update(
                {word: ways for word in sorted(wanted - self._ways.keys()) if (ways := espeak.pronunciations(word))}
            )

    def _look_up(self, dictionary, wanted: set[str]) -> None:
        with open(dictionary, encoding="utf-8", errors="replace") as lines:
            for line in _beginnings(lines):
                parts = line.split(None, 1)
                if len(parts) == 2 and (word := parts[0].partition("(")[0]) in wanted:
                    ways = self._ways.setdefault(word, [])
                    if len(ways) < _WAYS:
                        ways.append(parts[1].strip())

    def known(self) -> dict[str, list[str]]:
        """All words that were found."""
        return self._ways

    def ways(self, word: str) -> list[str]:
        """Pronunciations of a word, at best those it has as it is written; none where nothing can be guessed either."""
        found = self._ways.get(word) or self._ways.get(word.lower(), [])[:1]
        guess = "" if found else phones(word, self._model.get("letters"))
        return found or ([guess] if guess.strip() else [])


def _beginnings(file: TextIO) -> Iterator[str]:
    """The lines of a file, of long ones the first letters."""
    whole = True
    while piece := file.readline(_LINE):
        if whole:
            yield piece
        whole = piece.endswith("\n")
