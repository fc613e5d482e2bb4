"""Transcripts in the forms people have: recognised by their content, read into pieces of text with the times that they state.

Plain text; SRT, WebVTT, ASS subtitles; Praat TextGrids; JSON of Whisper, whisper.cpp, WhisperX, Google, GENEA, Gentle, the
Montreal Forced Aligner, Vosk, Amazon, Deepgram and our own ``[word, start, end]``; NIST CTM; labels in columns
(Audacity, GENEA, MFA, Whisper).
Every reader raises :class:`TranscriptUnreadable` in one sentence for what it cannot read.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import TranscriptUnreadable

LONGEST = 1e9
"""Seconds; no time is later."""


@dataclass(frozen=True)
class Item:
    """Some text, its ``start`` and ``end`` in seconds (None: unknown), and whether it is one ``word`` with times of its own."""

    text: str
    start: float | None = None
    end: float | None = None
    word: bool = False


@dataclass(frozen=True)
class Source:
    """What a file holds: its ``form`` for people, and its items in the order of the text."""

    form: str
    items: list[Item] = field(default_factory=list)


def parse(content: str, path: Path) -> Source:
    """The items of a transcript; ``path`` is for messages and for what the content leaves open."""
    from . import columns, jsons, subtitles, textgrid

    head = content.lstrip("\ufeff \t\r\n")
    if path.suffix.lower() == ".json" or re.match(r'[\[{]\s*(["\[{]|[\]}]\s*$)', head):
        source = jsons.parse(content, path)
    elif textgrid.is_textgrid(head):
        source = textgrid.parse(content, path)
    elif (form := subtitles.form(head)) is not None:
        source = subtitles.parse(content, form, path)
    elif (form := columns.form(content)) is not None:
        source = columns.parse(content, form, path)
    elif head.startswith(("<?xml", "<tt", "<!DOCTYPE")):
        raise TranscriptUnreadable(f"{path} is XML, which is not read.", "Export it as SRT, WebVTT or plain text.")
    else:
        return Source("plain text", [Item(content)])
    return Source(source.form, _cleaned(source.items))


def _cleaned(items: list[Item]) -> list[Item]:
    """Items with text, in order of time where all have one."""
    kept = [item for item in items if item.text.strip()]
    if all(item.start is not None for item in kept):
        kept.sort(key=lambda item: item.start)
    return kept


def times(start: object, end: object) -> tuple[float, float] | None:
    """Two moments in seconds from numbers, ``"1.5"``, ``"1.5s"`` or ``{"seconds": "1", "nanos": 5}``; None for others."""
    first, last = _seconds(start), _seconds(end)
    if first is None or last is None or not 0 <= first <= last < LONGEST:
        return None
    return first, last


def _seconds(value: object) -> float | None:
    if isinstance(value, dict) and set(value) <= {"seconds", "nanos"}:
        seconds, nanos = _seconds(value.get("seconds", 0)), _seconds(value.get("nanos", 0))
        return None if seconds is None or nanos is None else seconds + nanos / 1e9
    if isinstance(value, str) and re.fullmatch(r"\d{1,12}(\.\d{0,12})?s?", value, re.ASCII):
        return float(value.rstrip("s"))
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LONGEST:
        return None
    return float(value)
