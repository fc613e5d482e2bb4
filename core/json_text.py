"""JSON that somebody else may have written: one reader for every door, which any text ends in a value or a sentence."""

import json
from os import PathLike

LARGEST = 64_000_000
"""Bytes; the largest files of ours are sheets and recognisers' transcripts of hours, a few megabytes."""
DEEPEST = 64
"""Levels of lists and objects; those that are read here have ten at most."""
_EXACT = 18
"""Digits of a whole number that fits 64 bits; what is longer becomes a float, as in most other languages."""


class NotJson(ValueError):
    """The text is no JSON that is read here; the message completes "It is no JSON: ..." in words for people."""


def read(path: str | PathLike, largest: int = LARGEST, once: bool = False):
    """The value in a file, of at most ``largest`` bytes in UTF-8; raises OSError and :class:`NotJson`."""
    with open(path, "rb") as file:
        return parse(file.read(largest + 1), largest, once)


def parse(text: str | bytes, largest: int = LARGEST, once: bool = False):
    """The value that ``text`` states, of at most ``largest`` letters or bytes; with ``once`` no key twice in one object.

    Raises :class:`NotJson`, also for half letters of UTF-16, which no file could hold.
    """
    if len(text) > largest:
        raise NotJson(f"it is larger than {largest // 1_000_000 or 1} MB")
    try:
        text = text.decode("utf-8-sig") if isinstance(text, bytes) else text.removeprefix("\ufeff")
        value = json.loads(text, parse_int=_whole, object_pairs_hook=_once if once else None)
    except UnicodeDecodeError as error:
        raise NotJson("it is no text in UTF-8") from error
    except json.JSONDecodeError as error:
        raise NotJson(f"{error.msg} at line {error.lineno}, column {error.colno}") from error
    except RecursionError as error:
        raise NotJson(_DEEP) from error
    _measure(value)
    if "\\ud" in text or "\\uD" in text:
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise NotJson("a text in it holds half a letter of UTF-16") from error
    return value


_DEEP = f"its lists and objects lie more than {DEEPEST} deep in each other"


def _measure(value) -> None:
    """Raise :class:`NotJson` for what would break whoever walks through it by recursion."""
    level, depth = [value], 0
    while level := [one for one in level if isinstance(one, list | dict)]:
        depth += 1
        if depth > DEEPEST:
            raise NotJson(_DEEP)
        level = [inner for one in level for inner in (one.values() if isinstance(one, dict) else one)]


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= _EXACT else float(digits)


def _once(pairs: list[tuple[str, object]]) -> dict:
    """An object; of two equal keys Python would silently keep the last."""
    found: dict = {}
    for key, value in pairs:
        if key in found:
            raise NotJson(f"it names {json.dumps(key[:80], ensure_ascii=False)} twice")
        found[key] = value
    return found
