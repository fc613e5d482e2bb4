"""What an animator asks of a take, as a small JSON document: a list of edits, each applied to what the former ones left."""

import json
from collections.abc import Callable, Iterable, Mapping
from os import PathLike

import numpy as np

from .. import json_text
from ..errors import UsageError
from ..files import whole_file
from .gestures import HANDS

FORMAT = 1
MOST = 2000
"""Edits of a document."""
LEAST, LARGEST = 0.4, 2.0
"""Sizes that a gesture can be given, as shares of the size that it has."""
_LONGEST = 13 * 3600.0
_FILE = 10_000_000
_NAME = 60


def _seconds(value) -> float:
    return _number(value, 0.0, _LONGEST)


def _number(value, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"not a number from {low:g} to {high:g}")
    return float(value)


def _size(value) -> float:
    return _number(value, LEAST, LARGEST)


def _whole(low: int) -> Callable:
    def read(value) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value < 2**31:
            raise ValueError(f"not a whole number from {low} on")
        return value

    return read


def _hand(value) -> str:
    if value not in HANDS:
        raise ValueError(f"not one of {', '.join(HANDS)}")
    return value


def _one_hand(value) -> str:
    if value not in HANDS[:2]:
        raise ValueError("not left or right")
    return value


def _name(value) -> str:
    if not isinstance(value, str) or not 0 < len(value.strip()) <= _NAME:
        raise ValueError("not a word")
    return value.strip()


def _vectors(*shape: int, unit: bool = False) -> Callable:
    def read(value) -> list:
        try:
            found = np.asarray(value, float)
        except (TypeError, ValueError):
            found = np.array(np.nan)
        if found.shape != shape or not np.isfinite(found).all() or (np.abs(found) > 100).any():
            raise ValueError(f"not {' times '.join(map(str, shape))} numbers")
        if unit and (np.linalg.norm(found, axis=-1) < 1e-6).any():
            raise ValueError("not directions: one is zero")
        return found.tolist()

    return read


_SHAPES = {"kind": _name, "hand": _hand, "size": _size}
ACTIONS: dict[str, tuple[dict, dict]] = {
    "move": ({"at": _seconds, "to": _seconds}, {}),
    "delete": ({"at": _seconds}, {}),
    "change": ({"at": _seconds}, _SHAPES),
    "add": ({}, {"at": _seconds, "word": _name, "nth": _whole(1), **_SHAPES}),
    "reroll": ({"from": _seconds, "to": _seconds}, {"seed": _whole(0)}),
    "style": ({"at": _seconds, "style": _name}, {}),
    "pose": ({"at": _seconds, "directions": _vectors(9, 3, unit=True)}, {}),
    "place": ({"from": _seconds, "to": _seconds, "hand": _one_hand, "place": _vectors(3)}, {}),
}
"""What can be done -> its keys that must be there, and those that may be, each with what reads its value."""


def check(edits) -> list[dict]:
    """The edits of a list that anybody may have written, each a dict with ``do`` and keys of :data:`ACTIONS`.

    Raises :class:`UsageError` that says which edit is wrong, and how.
    """
    if not isinstance(edits, (list, tuple)) or len(edits) > MOST:
        raise UsageError(f"Edits are not a list of at most {MOST}.", "docs/directing.md describes them.")
    return [_checked(number, one) for number, one in enumerate(edits, 1)]


def _checked(number: int, edit) -> dict:
    try:
        return _read(edit)
    except ValueError as error:
        raise UsageError(f"Edit {number} is not usable: {error}.", "docs/directing.md describes them.") from None


def _read(edit) -> dict:
    if not isinstance(edit, Mapping):
        raise ValueError("it is no object")
    action = edit.get("do")
    if not isinstance(action, str) or action not in ACTIONS:
        raise ValueError(f"it does not do one of {', '.join(ACTIONS)}")
    needed, may = ACTIONS[action]
    known = needed | may
    strange = edit.keys() - known.keys() - {"do"}
    if strange:
        raise ValueError(f"{action} has no {sorted(map(str, strange))[0]!r}")
    missing = needed.keys() - edit.keys()
    if missing:
        raise ValueError(f"{action} needs {', '.join(name for name in needed if name in missing)}")
    read = {"do": action}
    for name, reader in known.items():
        if name in edit:
            try:
                read[name] = reader(edit[name])
            except ValueError as error:
                raise ValueError(f"{name} is {error}") from None
    _agree(action, read)
    return read


def _agree(action: str, edit: dict) -> None:
    if "from" in edit and edit["to"] <= edit["from"]:
        raise ValueError("it ends before it begins")
    if action == "change" and not edit.keys() & _SHAPES.keys():
        raise ValueError("it changes nothing: give kind, hand or size")
    if action == "add" and ("at" in edit) == ("word" in edit):
        raise ValueError("it needs a time or a word")
    if "nth" in edit and "word" not in edit:
        raise ValueError("nth counts words, and there is none")


def load(path: str | PathLike) -> list[dict]:
    """The edits of a file; raises :class:`UsageError`."""
    try:
        content = json_text.read(path, _FILE, once=True)
    except OSError as error:
        raise UsageError(f"The edits {path} cannot be read: {error.strerror}.", "Name a JSON file of edits.") from error
    except json_text.NotJson as error:
        raise UsageError(f"The edits {path} are no JSON: {error}.", "docs/directing.md describes them.") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT or not content.keys() <= {"format", "edits"}:
        raise UsageError(f"{path} holds no edits of format {FORMAT}.", "docs/directing.md describes them.")
    return check(content.get("edits", []))


def save(edits: Iterable[Mapping], path: str | PathLike) -> None:
    """Write a document, whole or not at all."""
    lines = ",\n  ".join(json.dumps(one) for one in edits)
    with whole_file(path) as temporary:
        temporary.write_text(f'{{"format": {FORMAT}, "edits": [\n  {lines}\n]}}\n', "utf-8")
