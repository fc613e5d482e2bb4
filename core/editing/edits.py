"""The edit document: a JSON list of edits to a take, each applied to the result of the ones before it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from .. import json_text
from ..errors import UsageError
from ..settings import AFFECTS
from .gestures import HANDS
from .names import LARGEST, LEAST

FORMAT = 1
MOST = 2000
"""Most edits in a document."""
_MAX_SECONDS = 13 * 3600.0
_MAX_BYTES = 10_000_000
_MAX_NAME = 60


def _seconds(value: object) -> float:
    return _number(value, 0.0, _MAX_SECONDS)


def _number(value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"not a number from {low:g} to {high:g}")
    return float(value)


def _whole(low: int) -> Callable[[object], int]:
    """Return a reader of whole numbers from ``low`` on."""

    def read(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value < 2**31:
            raise ValueError(f"not a whole number from {low} on")
        return value

    return read


def _name(value: object) -> str:
    if not isinstance(value, str) or not 0 < len(value.strip()) <= _MAX_NAME:
        raise ValueError("not a word")
    return value.strip()


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("not true or false")
    return value


def _times(value: object) -> float | list[float]:
    """Read a time, or a list of several."""
    if isinstance(value, (list, tuple)):
        if not 0 < len(value) <= MOST:
            raise ValueError("no list of times")
        return [_seconds(one) for one in value]
    return _seconds(value)


def _one_of(*choices: str) -> Callable[[object], str]:
    """Return a reader of one of these words."""

    def read(value: object) -> str:
        if not isinstance(value, str) or value not in choices:
            raise ValueError(f"not one of {', '.join(choices)}")
        return value

    return read


def _vectors(*shape: int, unit: bool = False) -> Callable[[object], list]:
    """Return a reader of finite arrays of this shape; with ``unit``, no vector may be zero."""

    def read(value: Any) -> list:
        try:
            array = np.asarray(value, float)
        except (TypeError, ValueError):
            array = np.array(np.nan)
        if array.shape != shape or not np.isfinite(array).all() or (np.abs(array) > 100).any():
            raise ValueError(f"not {' times '.join(map(str, shape))} numbers")
        if unit and (np.linalg.norm(array, axis=-1) < 1e-6).any():
            raise ValueError("not directions: one is zero")
        return array.tolist()

    return read


RESTS = ("none", "calmer", "fewer")
"""What a rest leaves of a range: no strokes, smaller and lower ones, or the larger half of them."""
FEELINGS = {name: lambda value: _number(value, -1.0, 1.0) for name in AFFECTS}
"""What a feeling may name, each from -1 to 1."""
_SHAPES = {"kind": _name, "hand": _one_of(*HANDS), "size": partial(_number, low=LEAST, high=LARGEST)}
_Readers = dict[str, Callable[[Any], Any]]
ACTIONS: dict[str, tuple[_Readers, _Readers]] = {
    "move": ({"at": _seconds, "to": _seconds}, {}),
    "delete": ({"at": _times}, {}),
    "rest": ({"from": _seconds, "to": _seconds}, {"how": _one_of(*RESTS)}),
    "change": ({"at": _seconds}, _SHAPES),
    "add": ({}, {"at": _seconds, "word": _name, "nth": _whole(1), **_SHAPES}),
    "reroll": ({"from": _seconds, "to": _seconds}, {"seed": _whole(0)}),
    "style": ({"at": _seconds, "style": _name}, {}),
    "feel": ({"at": _seconds}, FEELINGS),
    "pose": ({"at": _seconds, "directions": _vectors(9, 3, unit=True)}, {}),
    "place": ({"from": _seconds, "to": _seconds, "hand": _one_of(*HANDS[:2]), "place": _vectors(3)}, {}),
}
"""Kind of edit -> its required keys and its optional keys, each with the function that reads and checks its value."""
TURNS = ("style", "feel")
"""Edits that change who performs, or how, from their moment on: all other edits of a document are made within them."""
OFF = "off"
"""Key that any edit may have; with ``true`` it stays in the document and is not done."""


def check(edits: object) -> list[dict]:
    """Validate a list of edits from any source; return them, each a dict with ``do`` and keys of :data:`ACTIONS`.

    Raises :class:`UsageError` naming the first edit that is wrong, and why."""
    if not isinstance(edits, (list, tuple)) or len(edits) > MOST:
        raise UsageError(f"Edits are not a list of at most {MOST}.", "docs/directing.md describes them.")
    return [_check(number, edit) for number, edit in enumerate(edits, 1)]


def _check(number: int, edit: object) -> dict:
    try:
        return _read(edit)
    except ValueError as error:
        raise UsageError(f"Edit {number} is not usable: {error}.", "docs/directing.md describes them.") from None


def _read(edit: object) -> dict:
    if not isinstance(edit, Mapping):
        raise ValueError("it is no object")
    action = edit.get("do")
    if not isinstance(action, str) or action not in ACTIONS:
        raise ValueError(f"it does not do one of {', '.join(ACTIONS)}")
    required, optional = ACTIONS[action]
    readers = required | optional | {OFF: _flag}
    unknown = edit.keys() - readers.keys() - {"do"}
    if unknown:
        raise ValueError(f"{action} has no {sorted(map(str, unknown))[0]!r}")
    missing = required.keys() - edit.keys()
    if missing:
        raise ValueError(f"{action} needs {', '.join(name for name in required if name in missing)}")
    values: dict[str, Any] = {"do": action}
    for name, reader in readers.items():
        if name in edit:
            try:
                values[name] = reader(edit[name])
            except ValueError as error:
                raise ValueError(f"{name} is {error}") from None
    _check_keys_together(action, values)
    return values


def _check_keys_together(action: str, edit: dict) -> None:
    """Raise ValueError where the keys of an edit contradict each other."""
    if "from" in edit and edit["to"] <= edit["from"]:
        raise ValueError("it ends before it begins")
    if action == "change" and not edit.keys() & _SHAPES.keys():
        raise ValueError("it changes nothing: give kind, hand or size")
    if action == "feel" and not edit.keys() & FEELINGS.keys():
        raise ValueError(f"it names no feeling: give {', '.join(FEELINGS)}")
    if action == "add" and ("at" in edit) == ("word" in edit):
        raise ValueError("it needs a time or a word")
    if "nth" in edit and "word" not in edit:
        raise ValueError("nth counts words, and there is none")


def active(edits: Iterable[dict]) -> list[dict]:
    """Return the edits that are not switched off."""
    return [edit for edit in edits if not edit.get(OFF)]


def performing_order(edits: Sequence[Mapping]) -> list[int]:
    """Return the numbers of edits, from 0, in the order in which they are done: :data:`TURNS` first, wherever they stand."""
    return sorted(range(len(edits)), key=lambda number: edits[number].get("do") not in TURNS)


def before_turn(edits: Sequence[Mapping], number: int) -> bool:
    """Return whether an edit was decided before a later one of :data:`TURNS`, after which it may not be possible any more."""
    return any(edit.get("do") in TURNS and not edit.get(OFF) for edit in edits[number + 1 :])


def load(path: str | PathLike) -> list[dict]:
    """Return the edits of a file; raises :class:`UsageError` if it is not readable or not valid."""
    try:
        content = json_text.read(path, _MAX_BYTES, once=True)
    except OSError as error:
        raise UsageError(f"The edits {path} cannot be read: {error.strerror}.", "Name a JSON file of edits.") from error
    except json_text.NotJson as error:
        raise UsageError(f"The edits {path} are no JSON: {error}.", "docs/directing.md describes them.") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT or not content.keys() <= {"format", "edits"}:
        raise UsageError(f"{path} holds no edits of format {FORMAT}.", "docs/directing.md describes them.")
    return check(content.get("edits", []))


def of(documents: Any) -> list[dict] | None:
    """Return the edits of the document that ``documents`` names, anything with the fields of :class:`settings.Documents`: the
    options of a command, a row of a manifest; None where it names none."""
    path = getattr(documents, "edits", None)
    return None if path is None else load(path)
