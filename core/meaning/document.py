"""Documents of meanings: which words of a talk are shown by which gesture, as people and language models write them.

docs/meaning.md describes them; :func:`s2ag.core.cli.meaning.write` makes them of what was understood."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, NamedTuple

from .. import json_text
from ..errors import UsageError

FORMAT = 1
SIDES = {"left": -1.0, "right": 1.0, "both": 0.0}
NUMBERS = {"nth": (1, 10_000), "size": (0.2, 1.6), "form": (1, 9), "sure": (0, 1)}
"""Numbers of an entry -> least and most."""
_TEXTS = "schema", "words", "on", "hand"
_MOST, _MAX_BYTES = 20_000, 8_000_000
_REMEDY = "docs/meaning.md describes the document."


class Wanted(NamedTuple):
    """A gesture for words: its ``schema``, how many words call for it, how ``sure`` 0..1 (None: it is shown in any case);
    ``side`` (-1, 1, 0 both), ``size`` (1 as usual) and number of its ``form``, None where seed and style choose. ``before``
    words the bearing one begin those that call for it."""

    schema: str
    count: int = 1
    sure: float | None = None
    side: float | None = None
    size: float | None = None
    form: int | None = None
    before: int = 0


def check(content: Any) -> dict[str, Any]:
    """Return a valid document from data of any origin; an empty one asks for nothing. Raises :class:`UsageError`."""
    if content == {}:
        return {}
    if not isinstance(content, Mapping) or content.get("format") != FORMAT:
        raise UsageError(f"That is no document of meanings of format {FORMAT}.", _REMEDY)
    entries = content.get("gestures")
    if not isinstance(entries, list) or len(entries) > _MOST or not content.keys() <= {"format", "gestures"}:
        raise UsageError("A document of meanings has format and a list of gestures, nothing else.", _REMEDY)
    for number, entry in enumerate(entries, 1):
        if not isinstance(entry, Mapping) or not entry.keys() <= {*_TEXTS, *NUMBERS}:
            what = f"A gesture has {', '.join((*_TEXTS, *NUMBERS))}, nothing else."
            raise UsageError(f"Gesture {number} of the meanings is of another form.", what)
        if wrong := next((name for name in (*_TEXTS, *NUMBERS) if not _fits(entry, name)), ""):
            low, high = NUMBERS.get(wrong, (0, 0))
            what = f"Give a number from {low:g} to {high:g}." if high else "Give a schema, words as they are said, and a hand."
            raise UsageError(f"Gesture {number} of the meanings has no usable {wrong}.", what)
    return dict(content)


def _fits(entry: Mapping, name: str) -> bool:
    """Return whether a value of an entry is what it has to be."""
    if name not in entry:
        return name not in ("schema", "words")
    value = entry[name]
    if name in NUMBERS:
        kind, (low, high) = int if name in ("nth", "form") else (int, float), NUMBERS[name]
        return isinstance(value, kind) and not isinstance(value, bool) and low <= value <= high
    if not isinstance(value, str) or not plain(value):
        return False
    words = plain(str(entry.get("words", "")))
    return value in SIDES if name == "hand" else name != "on" or set(plain(value)) <= set(words)


def load(path: str | PathLike) -> dict[str, Any]:
    """Read a document of meanings; raises :class:`UsageError`."""
    try:
        return check(json_text.read(path, _MAX_BYTES, once=True) or None)
    except OSError as error:
        raise UsageError(f"The meanings {path} cannot be read: {error.strerror}.", "Name a JSON file of meanings.") from error
    except json_text.NotJson as error:
        raise UsageError(f"The meanings {path} are no JSON: {error}.", _REMEDY) from error


def of(options: Any) -> dict[str, Any]:
    """Return the document that the options of a command or a row of a manifest name, under the setting's name, or {}."""
    path = getattr(options, "meanings", None)
    return {} if path is None else {"meanings": load(path)}


def plain(text: str) -> list[str]:
    """Return the words of a text in lower case without punctuation, as they are compared."""
    words = (word.strip(".,;:!?…\"'()[]“”„«»‘’*-–—") for word in text.lower().replace("’", "'").split())
    return [word for word in words if word]


def find(document: Mapping[str, Any], texts: Sequence[str], schemas: Mapping) -> tuple[dict[int, Wanted], list[str]]:
    """Find the words of a document among the words of a talk: number of the word that bears a gesture -> the gesture.

    An entry's words are looked for after those of the entry before it, or are counted from the beginning with ``nth``. Also
    returns a sentence for each entry whose words are not said. Raises :class:`UsageError` for an unknown schema."""
    said = [" ".join(plain(text)) for text in texts]
    found, missed, start = {}, [], 0
    for number, entry in enumerate(document["gestures"], 1):
        if entry["schema"] not in schemas:
            raise UsageError(f"The meanings name a schema {entry['schema']!r:.40}.", f"Schemas are {', '.join(schemas)}.")
        words, nth = plain(entry["words"]), entry.get("nth", 1)
        first, after = words[0], 0 if "nth" in entry else start
        places = (at for at in range(after, len(said)) if said[at] == first and said[at : at + len(words)] == words)
        place = next((at for count, at in enumerate(places, 1) if count == nth), None)
        if place is None:
            missed.append(f"The words “{entry['words']:.60}” of gesture {number} of the meanings are not said there.")
            continue
        bearer = words.index(plain(entry["on"])[0]) if "on" in entry else len(words) - 1
        start = place + bearer + 1
        numbers = (entry.get("sure"), SIDES.get(entry.get("hand", "")), entry.get("size"), entry.get("form"))
        found[place + bearer] = Wanted(entry["schema"], len(words), *numbers, bearer)
    return found, missed
