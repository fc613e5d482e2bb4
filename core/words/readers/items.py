"""The result of every reader: pieces of text with the times that the file states."""

import re
from dataclasses import dataclass, field

MAX_SECONDS = 1e9
"""Seconds; later times are invalid."""


@dataclass(frozen=True)
class Item:
    """A piece of text, its ``start`` and ``end`` in seconds (None: unknown), and whether it is one ``word`` with own times."""

    text: str
    start: float | None = None
    end: float | None = None
    word: bool = False


@dataclass(frozen=True)
class Source:
    """A parsed transcript: its ``form``, a readable name of the format, and its items in the order of the text."""

    form: str
    items: list[Item] = field(default_factory=list)


def parse_times(start: object, end: object) -> tuple[float, float] | None:
    """Convert start and end to seconds, from numbers, ``"1.5"``, ``"1.5s"`` or ``{"seconds": "1", "nanos": 5}``.

    Returns None unless both are valid and in order."""
    first, last = _seconds(start), _seconds(end)
    if first is None or last is None or not 0 <= first <= last < MAX_SECONDS:
        return None
    return first, last


def _seconds(value: object) -> float | None:
    if isinstance(value, dict) and set(value) <= {"seconds", "nanos"}:
        seconds, nanos = _seconds(value.get("seconds", 0)), _seconds(value.get("nanos", 0))
        return None if seconds is None or nanos is None else seconds + nanos / 1e9
    if isinstance(value, str) and re.fullmatch(r"\d{1,12}(\.\d{0,12})?s?", value, re.ASCII):
        return float(value.rstrip("s"))
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < MAX_SECONDS:
        return None
    return float(value)
