"""Subtitles through pysubs2: SRT, WebVTT (with the word times that some of it carries) and ASS."""

import re
import warnings
from pathlib import Path

from ...errors import EngineMissing, TranscriptUnreadable
from .items import LONGEST, Item, Source

_CUE = re.compile(r"^\s*(?:\d+:)?\d+:\d\d[,.]\d+\s*-->\s*(?:\d+:)?\d+:\d\d[,.]\d+", re.MULTILINE)
_STAMP = re.compile(r"<((?:\d{1,3}:)?\d\d:\d\d\.\d{3})>")
_TAG = re.compile(r"</?[a-zA-Z][^<>]{0,200}>|\{\\[^{}]{0,200}\}")
_OVERRIDE = re.compile(r"\{[^{}]*\}")
"""What ASS states of the looks of a text; pysubs2's own expression takes the square of the time."""
_NAMES = {"vtt": "WebVTT", "srt": "SRT", "ass": "ASS"}


def form(head: str) -> str | None:
    """``vtt``, ``srt`` or ``ass``, or None for another text."""
    if head.startswith("WEBVTT"):
        return "vtt"
    if head.startswith("[Script Info]"):
        return "ass"
    return "srt" if _CUE.search(head[:5000]) else None


def parse(content: str, form: str, path: Path) -> Source:
    """One item for every cue, or for every word of a cue that holds word times."""
    try:
        import pysubs2
    except ModuleNotFoundError as error:
        raise EngineMissing.of(error) from error
    if form == "vtt":  # notes and styles are no speech; pysubs2 takes them for text of the cue before
        content = re.sub(r"^(NOTE|STYLE|REGION)\b.*?(?=\n\s*\n|\Z)", "", content.replace("\r\n", "\n"), flags=re.M | re.S)
    options = {"keep_html_tags": True} if form in ("srt", "vtt") else {}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of columns that nobody needs here
            cues = [cue for cue in pysubs2.SSAFile.from_string(content, format_=form, **options) if not cue.is_comment]
        spans = [(cue.start / 1000, cue.end / 1000, cue.text if options else _bare(cue.text)) for cue in cues]
    except Exception as error:  # pysubs2 lets through what its own parsing runs into
        raise TranscriptUnreadable(f"{path} is a damaged {_NAMES[form]} file.", "Export it again.") from error
    items: list[Item] = []
    said = ""
    for start, end, text in sorted(spans, key=lambda span: span[0]):
        if 0 <= start <= end < LONGEST:
            text = text.replace("\\N", "\n").replace("\\h", " ")
            rolled, said = _unrolled(text, said)
            items += _timed(rolled, start, end) if _STAMP.search(rolled) else [Item(_plain(rolled), start, end)]
    return Source(_NAMES[form], items)


def _bare(text: str) -> str:
    return _OVERRIDE.sub("", text).replace("\\n", "\n")


def _unrolled(text: str, before: str) -> tuple[str, str]:
    """Roll-up captions repeat the line above: lines of the last cue are left out. The rest, and this cue's plain text."""
    lines = [line for line in text.split("\n") if line.strip()]
    known = before.split("\n")
    plain = "\n".join(_plain(line) for line in lines)
    while lines and _plain(lines[0]) and _plain(lines[0]) == known[-1] and len(lines) > 1:
        lines.pop(0)
    return "\n".join(lines), plain


def _timed(text: str, start: float, end: float) -> list[Item]:
    """Words of a cue in which every word but the first follows its own time."""
    parts = _STAMP.split(text)
    stamps = [start, *(_seconds(part) for part in parts[1::2]), end]
    items = []
    for number, part in enumerate(parts[::2]):
        text, low = _plain(part).strip(), min(max(stamps[number], start), end)
        high = min(max(stamps[number + 1], low), end)
        if text:
            items.append(Item(text, low, high, word=len(text.split()) == 1))
    return items


def _seconds(stamp: str) -> float:
    value = 0.0
    for part in stamp.split(":"):
        value = 60 * value + float(part)
    return value


def _plain(text: str) -> str:
    text = _TAG.sub("", _STAMP.sub("", text))
    for entity, char in (("&nbsp;", " "), ("&lt;", "<"), ("&gt;", ">"), ("&lrm;", ""), ("&rlm;", ""), ("&amp;", "&")):
        text = text.replace(entity, char)
    return text.strip()
