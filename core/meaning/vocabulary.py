"""Phrases that have a gesture of their own, as data that a user can extend: what is said, and what the body shows for it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path

from .. import json_text
from ..errors import UsageError
from .gesture import ANGLES, Gesture, read_shape

PATH = Path(__file__).parents[1] / "assets" / "vocabulary.json"
_LARGEST = 1_000_000
"""Bytes of a file: the shipped one has 9,000."""
_KEYS = {"says", "marks", "arms", "ready", "stroke", "palm", "knuckles", "shape", "often", "clip", "lands"} | set(ANGLES)


@dataclass(frozen=True)
class Vocabulary:
    """``gestures`` by name; ``phrases``: first word -> ``(words, number of the bearing one, gesture)``, longest first;
    ``marks``: hint of a transcript -> gesture."""

    gestures: dict[str, Gesture]
    phrases: dict[str, tuple]
    marks: dict[str, str]

    def find(self, words: Sequence[str], breaks: Sequence[bool] = ()) -> dict[int, tuple[str, int]]:
        """Number of the bearing word -> gesture and how many words say it; longer phrases win, and no word is in two.

        ``words`` are in lower case without marks; ``breaks[k]``: the sentence ends after word ``k``.
        """
        found, at = {}, 0
        while at < len(words):
            for phrase, bearer, gesture in self.phrases.get(words[at], ()):
                end = at + len(phrase)
                if tuple(words[at:end]) == phrase and not any(breaks[at : end - 1]):
                    found[at + bearer] = gesture, len(phrase)
                    at = end - 1
                    break
            at += 1
        return found


def load(extra: str | PathLike | None = None) -> Vocabulary:
    """The shipped vocabulary; gestures and handshapes of the file ``extra`` are added or take the place of those so named.

    :class:`UsageError` with a sentence for a file that is none.
    """
    return _made(*_shipped()) if extra is None else _extended(extra)


@lru_cache(maxsize=1)
def _shipped() -> tuple[dict, dict]:
    content = json.loads(PATH.read_text("utf-8"))
    return content["gestures"], content["shapes"]


def _extended(path: str | PathLike) -> Vocabulary:
    gestures, shapes = _shipped()
    try:
        own = _content(Path(path))
        return _made({**gestures, **own.get("gestures", {})}, {**shapes, **own.get("shapes", {})}, Path(path).parent)
    except OSError as error:
        raise UsageError(f"The vocabulary {path} cannot be read: {error.strerror}.", "Name a JSON file of gestures.") from error
    except ValueError as error:
        raise UsageError(f"The vocabulary {path} is not usable: {error}.", "docs/transcripts.md describes it.") from error


def _content(path: Path) -> dict:
    content = json_text.read(path, _LARGEST)
    if not isinstance(content, dict) or not content.keys() <= {"gestures", "shapes"}:
        raise ValueError("it holds something else than gestures and shapes")
    if not all(isinstance(part, dict) for part in content.values()):
        raise ValueError("gestures and shapes are named")
    return content


def _made(gestures: Mapping, shapes: Mapping, folder: Path | None = None) -> Vocabulary:
    known = {name: read_shape(name, values) for name, values in shapes.items()}
    read, phrases, marks = {}, {}, {}
    for name, given in gestures.items():
        if not isinstance(given, dict) or not given.keys() <= _KEYS:
            raise ValueError(f"{name} has something else than {', '.join(sorted(_KEYS))}")
        read[name] = Gesture.read(name, given, known, folder)
        for phrase in _texts(name, "says", given):
            words, bearer = _phrase(phrase)
            phrases.setdefault(words[0], []).append((words, bearer, name))
        marks |= dict.fromkeys(_texts(name, "marks", given), name)
    longest_first = {first: tuple(sorted(each, key=lambda one: -len(one[0]))) for first, each in phrases.items()}
    return Vocabulary(read, longest_first, marks)


def _texts(name: str, key: str, given: dict) -> list[str]:
    texts = given.get(key, [])
    if not isinstance(texts, list) or not all(isinstance(text, str) and text.strip(" *") for text in texts):
        raise ValueError(f"{key} of {name} is not a list of words")
    return texts


def _phrase(phrase: str) -> tuple[tuple[str, ...], int]:
    """Words of a phrase, and the number of the one that a star follows, the last one without a star."""
    words = phrase.lower().split()
    starred = [number for number, word in enumerate(words) if word.endswith("*")]
    return tuple(word.rstrip("*") for word in words), starred[0] if starred else len(words) - 1
