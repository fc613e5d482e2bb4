"""Loads the vocabulary of semantic gestures, which maps phrases to gestures and can be extended by the user."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from .. import json_text
from ..errors import UsageError
from .gesture import ANGLES, Gesture, read_shape

PATH = Path(__file__).parents[1] / "assets" / "vocabulary.json"
_MAX_BYTES = 1_000_000
"""Of a vocabulary file; the shipped one has 20,000."""
_POSES = {"ready", "stroke", "path", "clip"}
_FORM = {"arms", "other", "palm", "knuckles", "shape", "other_shape", "often", "seconds", "side", "lands", *_POSES, *ANGLES}
_KEYS = _FORM | {"says", "marks", "variants"}


@dataclass(frozen=True)
class Vocabulary:
    """Semantic ``gestures`` by name, and all ``forms`` of each, the first of which it is.

    ``phrases``: first word -> ``(words, number of the word that carries the gesture, name of the gesture)``, longest first;
    ``marks``: hint of a transcript -> name of the gesture."""

    gestures: dict[str, Gesture]
    phrases: dict[str, tuple]
    marks: dict[str, str]
    forms: dict[str, tuple[Gesture, ...]]

    def find(self, words: Sequence[str], breaks: Sequence[bool] = ()) -> dict[int, tuple[str, int, int]]:
        """Find the phrases in a text: number of the word that carries the gesture -> its name, number of words, and
        of those before it.

        Longer phrases win, and phrases do not overlap. ``words`` are in lower case without punctuation; ``breaks[k]`` tells
        that a sentence ends after word ``k``."""
        matches, at = {}, 0
        while at < len(words):
            for phrase, bearer, gesture in self.phrases.get(words[at], ()):
                end = at + len(phrase)
                if tuple(words[at:end]) == phrase and not any(breaks[at : end - 1]):
                    matches[at + bearer] = gesture, len(phrase), bearer
                    at = end - 1
                    break
            at += 1
        return matches


def load_vocabulary(extra: str | PathLike | None = None) -> Vocabulary:
    """Load the shipped vocabulary; gestures and handshapes of the file ``extra`` are added or replace those of the same name. A
    gesture without poses adds words and marks to the shipped one.

    Raises :class:`UsageError` if the file is not a vocabulary."""
    return _build(*_shipped()) if extra is None else _load_extended(extra)


@lru_cache(maxsize=1)
def _shipped() -> tuple[dict, dict]:
    content = json.loads(PATH.read_text("utf-8"))
    return content["gestures"], content["shapes"]


def _load_extended(path: str | PathLike) -> Vocabulary:
    gestures, shapes = _shipped()
    try:
        own = _content(Path(path))
        added = {
            name: {**gestures[name], **entry} if name in gestures and not _POSES & set(entry) else entry
            for name, entry in own.get("gestures", {}).items()
        }
        return _build({**gestures, **added}, {**shapes, **own.get("shapes", {})}, Path(path).parent)
    except OSError as error:
        raise UsageError(f"The vocabulary {path} cannot be read: {error.strerror}.", "Name a JSON file of gestures.") from error
    except ValueError as error:
        raise UsageError(f"The vocabulary {path} is not usable: {error}.", "docs/transcripts.md describes it.") from error


def _content(path: Path) -> dict[str, Any]:
    """Read the JSON of a vocabulary; raises ``ValueError``."""
    content = json_text.read(path, _MAX_BYTES)
    if not isinstance(content, dict) or not content.keys() <= {"gestures", "shapes"}:
        raise ValueError("it holds something else than gestures and shapes")
    if not all(isinstance(part, dict) for part in content.values()):
        raise ValueError("gestures and shapes are named")
    return content


def _build(gestures: Mapping[str, Any], shapes: Mapping[str, Any], folder: Path | None = None) -> Vocabulary:
    """Build a vocabulary from JSON objects, whose clips lie in ``folder``; raises ``ValueError``."""
    handshapes = {name: read_shape(name, values) for name, values in shapes.items()}
    read, phrases, marks, forms = {}, {}, {}, {}
    for name, entry in gestures.items():
        if not isinstance(entry, dict) or not entry.keys() <= _KEYS:
            raise ValueError(f"{name} has something else than {', '.join(sorted(_KEYS))}")
        read[name] = Gesture.read(name, entry, handshapes, folder)
        others = entry.get("variants", [])
        if not isinstance(others, list) or not all(isinstance(one, dict) and one.keys() <= _FORM for one in others):
            raise ValueError(f"variants of {name} are not a list of forms")
        forms[name] = (read[name], *(Gesture.read(name, one, handshapes, folder) for one in others))
        for phrase in _texts(name, "says", entry):
            words, bearer = _phrase(phrase)
            phrases.setdefault(words[0], []).append((words, bearer, name))
        marks |= dict.fromkeys(_texts(name, "marks", entry), name)
    longest_first = {first: tuple(sorted(each, key=lambda phrase: -len(phrase[0]))) for first, each in phrases.items()}
    return Vocabulary(read, longest_first, marks, forms)


def _texts(name: str, key: str, entry: dict[str, Any]) -> list[str]:
    """Return the list of texts under a key of a gesture; raises ``ValueError``."""
    texts = entry.get(key, [])
    if not isinstance(texts, list) or not all(isinstance(text, str) and text.strip(" *") for text in texts):
        raise ValueError(f"{key} of {name} is not a list of words")
    return texts


def _phrase(phrase: str) -> tuple[tuple[str, ...], int]:
    """Split a phrase into words; return them and the number of the word with a star, of the last one if there is none."""
    words = phrase.lower().split()
    starred = [number for number, word in enumerate(words) if word.endswith("*")]
    return tuple(word.rstrip("*") for word in words), starred[0] if starred else len(words) - 1
