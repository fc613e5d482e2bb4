"""Safe reader of untrusted JSON: every text gives a value or one kind of error."""

import json
from os import PathLike
from typing import Any

from .files import open_file

MAX_BYTES = 64_000_000
"""Largest text in bytes; sample sheets and transcripts of hours have a few megabytes."""
MAX_DEPTH = 64
"""Deepest nesting; this project's formats have ten levels at most."""
_MAX_DIGITS = 18
"""Digits of integers that fit 64 bits; longer ones become floats, as in most other languages."""


class NotJson(ValueError):
    """The text is not accepted as JSON; the message, for users, completes "It is no JSON: ..."."""


def read(path: str | PathLike, largest: int = MAX_BYTES, once: bool = False) -> Any:
    """Read a JSON file of at most ``largest`` bytes in UTF-8; raises OSError and :class:`NotJson`."""
    with open_file(path) as file:
        return parse(file.read(largest + 1), largest, once)


def parse(text: str | bytes, largest: int = MAX_BYTES, once: bool = False) -> Any:
    """Parse JSON of at most ``largest`` characters or bytes; with ``once`` duplicate keys are errors.

    Raises :class:`NotJson`, also for unpaired UTF-16 surrogates, which cannot be encoded."""
    if len(text) > largest:
        raise NotJson(f"it is larger than {largest // 1_000_000 or 1} MB")
    try:
        text = text.decode("utf-8-sig") if isinstance(text, bytes) else text.removeprefix("\ufeff")
        twice = _unique_keys if once else None
        value = json.loads(text, parse_int=lambda n: int(n) if len(n) <= _MAX_DIGITS else float(n), object_pairs_hook=twice)
    except UnicodeDecodeError as error:
        raise NotJson("it is no text in UTF-8") from error
    except json.JSONDecodeError as error:
        raise NotJson(f"{error.msg} at line {error.lineno}, column {error.colno}") from error
    except RecursionError as error:
        raise NotJson(_TOO_DEEP) from error
    _check_depth(value)
    if "\\ud" in text or "\\uD" in text:
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise NotJson("a text in it holds half a letter of UTF-16") from error
    return value


_TOO_DEEP = f"its lists and objects lie more than {MAX_DEPTH} deep in each other"


def _check_depth(value: Any) -> None:
    """Raise :class:`NotJson` for nesting so deep that recursion over the value could fail."""
    level, depth = [value], 0
    while level := [item for item in level if isinstance(item, list | dict)]:
        depth += 1
        if depth > MAX_DEPTH:
            raise NotJson(_TOO_DEEP)
        level = [inner for item in level for inner in (item.values() if isinstance(item, dict) else item)]


def _unique_keys(pairs: list[tuple[str, object]]) -> dict:
    """Build an object; raises :class:`NotJson` for duplicate keys, of which Python would silently keep the last."""
    result: dict = {}
    for key, value in pairs:
        if key in result:
            raise NotJson(f"it names {json.dumps(key[:80], ensure_ascii=False)} twice")
        result[key] = value
    return result
