"""Reads timed words in columns: NIST CTM, labels of Audacity, GENEA and Whisper (tab-separated) and of the MFA (CSV)."""

import csv
import io
import re
from collections.abc import Iterator
from pathlib import Path

from ...errors import TranscriptUnreadable
from .items import Item, Source, parse_times

_NUMBER = r"\d+(?:\.\d*)?|\.\d+"
_CTM = re.compile(rf"\S+\s+\S+\s+({_NUMBER})\s+({_NUMBER})\s+(\S+)(\s+\S+)*")
_LABEL = re.compile(rf"({_NUMBER})\t({_NUMBER})\t(.+)")
_EMPTY = {"<eps>", "<sil>", "sil", "sp", "<unk>", "[noise]", "[laughter]", "!sil"}


def detect(content: str) -> str | None:
    """Detect the format: ``ctm``, ``labels``, ``whisper`` or ``mfa``, or None for another text."""
    lines = _lines(content)
    if not lines:
        return None
    if lines[0].lower().split(",")[:3] == ["begin", "end", "label"]:
        return "mfa"
    if lines[0].lower().split("\t") == ["start", "end", "text"]:
        return "whisper"
    for name, shape in (("labels", _LABEL), ("ctm", _CTM)):
        if all(shape.fullmatch(line) for line in lines[:50]):
            return name
    return None


def parse(content: str, form: str, path: Path) -> Source:
    """Parse a file of this :func:`detect`. Raises :class:`TranscriptUnreadable`."""
    if form == "mfa":
        return Source("labels of the Montreal Forced Aligner", _mfa(content, path))
    lines = _lines(content)
    if form == "ctm":
        return Source("CTM", [item for number, line in enumerate(lines, 1) for item in _ctm(line, number, path)])
    scale = 0.001 if form == "whisper" else 1.0
    items = []
    for number, line in enumerate(lines[form == "whisper" :], 1):
        fields = line.split("\t", 2)
        span = parse_times(*(_seconds(part, scale) for part in fields[:2])) if len(fields) == 3 else None
        if span is None:
            raise TranscriptUnreadable(f"Label {number} of {path} has no start, end and text.", "Separate them by tabs.")
        items.append(Item(fields[2].strip(), *span, word=len(fields[2].split()) == 1))
    return Source("labels", items)


def _ctm(line: str, number: int, path: Path) -> Iterator[Item]:
    """Yield the word of a CTM line, or nothing for silence and noise."""
    match = _CTM.fullmatch(line)
    if match is None:
        raise TranscriptUnreadable(f"Line {number} of {path} is not CTM.", "Write: recording channel start duration word.")
    span = parse_times(float(match[1]), float(match[1]) + float(match[2]))
    if span is None:
        raise TranscriptUnreadable(f"Line {number} of {path} has no sensible time.", "Times are in seconds.")
    if match[3].lower() not in _EMPTY:
        yield Item(match[3], *span, word=True)


def _mfa(content: str, path: Path) -> list[Item]:
    """Parse CSV of the Montreal Forced Aligner: begin, end, label and, in some files, the type of the row."""
    try:
        rows = list(csv.reader(io.StringIO(content.strip("\ufeff\r\n ").replace("\0", ""))))
    except csv.Error as error:
        raise TranscriptUnreadable(f"{path} is not a readable CSV file.", "Export it again.") from error
    items = []
    for number, row in enumerate(rows[1:], 2):
        if len(row) > 3 and row[3] != "words" or not row:
            continue
        span = parse_times(*row[:2]) if len(row) > 2 else None
        if span is None:
            raise TranscriptUnreadable(f"Row {number} of {path} has no begin, end and label.", "Export it again.")
        if row[2].lower() not in _EMPTY:
            items.append(Item(row[2], *span, word=True))
    return items


def _seconds(text: str, scale: float) -> float | None:
    """Parse a number and multiply it by ``scale``; None if it is none."""
    return float(text) * scale if re.fullmatch(_NUMBER, text, re.ASCII) else None


def _lines(content: str) -> list[str]:
    lines = (line.strip(" \r\ufeff") for line in content.split("\n"))
    return [line for line in lines if line.strip() and not line.startswith(";;")]
