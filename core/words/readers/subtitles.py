"""Reads subtitles with pysubs2: SRT, WebVTT (with word times, if any) and ASS."""

import re
import warnings
from pathlib import Path

import pysubs2

from ...errors import TranscriptUnreadable
from .items import MAX_SECONDS, Item, Source

_STAMP = re.compile(r"<((?:\d{1,3}:)?\d\d:\d\d\.\d{3})>")
_TAG = re.compile(r"</?[a-zA-Z][^<>]{0,200}>|\{\\[^{}]{0,200}\}")
_OVERRIDE = re.compile(r"\{[^{}]*\}")
"""Formatting in ASS; pysubs2's own expression for it takes quadratic time."""
_NAMES = {"vtt": "WebVTT", "srt": "SRT", "ass": "ASS"}


def parse(content: str, form: str, path: Path) -> Source:
    """Parse subtitles: one item for every cue, or for every word of a cue that has word times.

    Raises :class:`TranscriptUnreadable`."""
    if form == "vtt":  # notes and styles are no speech, but pysubs2 adds them to the text of the previous cue
        content = re.sub(r"^(NOTE|STYLE|REGION)\b.*?(?=\n\s*\n|\Z)", "", content.replace("\r\n", "\n"), flags=re.M | re.S)
    options = {"keep_html_tags": True} if form in ("srt", "vtt") else {}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about columns that are not used here
            cues = [cue for cue in pysubs2.SSAFile.from_string(content, format_=form, **options) if not cue.is_comment]
        spans = [(cue.start / 1000, cue.end / 1000, cue.text if options else _strip_overrides(cue.text)) for cue in cues]
    except Exception as error:  # pysubs2 does not catch the errors of its own parsing
        raise TranscriptUnreadable(f"{path} is a damaged {_NAMES[form]} file.", "Export it again.") from error
    items: list[Item] = []
    said = ""
    for start, end, text in sorted(spans, key=lambda span: span[0]):
        if 0 <= start <= end < MAX_SECONDS:
            text = text.replace("\\N", "\n").replace("\\h", " ")
            rolled, said = _drop_repeated_lines(text, said)
            items += _timed_words(rolled, start, end) if _STAMP.search(rolled) else [Item(_strip_tags(rolled), start, end)]
    return Source(_NAMES[form], items)


def _strip_overrides(text: str) -> str:
    return _OVERRIDE.sub("", text).replace("\\n", "\n")


def _drop_repeated_lines(text: str, before: str) -> tuple[str, str]:
    """Remove lines at the start that repeat the last line of the previous cue ``before``, as in roll-up captions.

    Returns the remaining text, and the full text of this cue without tags."""
    lines = [line for line in text.split("\n") if line.strip()]
    previous = before.split("\n")
    plain = "\n".join(_strip_tags(line) for line in lines)
    while lines and _strip_tags(lines[0]) and _strip_tags(lines[0]) == previous[-1] and len(lines) > 1:
        lines.pop(0)
    return "\n".join(lines), plain


def _timed_words(text: str, start: float, end: float) -> list[Item]:
    """Split a cue in which every word but the first is preceded by its start time; return its words."""
    parts = _STAMP.split(text)
    stamps = [start, *(_seconds(part) for part in parts[1::2]), end]
    items = []
    for number, part in enumerate(parts[::2]):
        text, low = _strip_tags(part).strip(), min(max(stamps[number], start), end)
        high = min(max(stamps[number + 1], low), end)
        if text:
            items.append(Item(text, low, high, word=len(text.split()) == 1))
    return items


def _seconds(stamp: str) -> float:
    """Parse ``h:mm:ss.mmm`` or ``mm:ss.mmm``."""
    value = 0.0
    for part in stamp.split(":"):
        value = 60 * value + float(part)
    return value


def _strip_tags(text: str) -> str:
    """Remove tags and time stamps, and decode entities."""
    text = _TAG.sub("", _STAMP.sub("", text))
    for entity, char in (("&nbsp;", " "), ("&lt;", "<"), ("&gt;", ">"), ("&lrm;", ""), ("&rlm;", ""), ("&amp;", "&")):
        text = text.replace(entity, char)
    return text.strip()
