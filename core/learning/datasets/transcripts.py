"""Reads the transcripts of data sets: Google's JSON, Praat's TextGrid, GENEA's tables, our JSON list, plain text."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ... import json_text
from ...errors import CorpusUnreadable
from ...files import read_bytes

Word = tuple[str, float, float]
SUFFIXES = (".json", ".TextGrid", ".txt")
LARGEST = 10_000_000
"""Most bytes of a table of words."""
_INTERVAL = re.compile(r'xmin\s*=\s*([-\d.eE+]+)\s+xmax\s*=\s*([-\d.eE+]+)\s+text\s*=\s*"((?:[^"]|"")*)"')


def read(path: Path, audio: np.ndarray) -> list[Word]:
    """Return the timed words of a transcript file; plain text is aligned to the ``audio``. Raises :class:`CorpusUnreadable`."""
    try:
        if path.suffix == ".TextGrid":
            return _timed(textgrid(path))
        if path.suffix == ".json":
            content = json_text.read(path)
            return _timed(google(content) if _is_google(content) else content)
        if path.suffix == ".tsv":
            return _timed(table(path))
    except (OSError, ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        raise CorpusUnreadable(f"The transcript {path} cannot be read: {reason}.", "Mend it or take it away.") from error
    from ...words.transcript import timed_transcript

    return list(timed_transcript(audio, path).words)


def transcript_beside(path: Path, folder: Path | None = None) -> Path | None:
    """Return the transcript of a recording, a file of the same name beside it or in ``folder``, or None."""
    places = (path.with_suffix(suffix) if folder is None else folder / f"{path.stem}{suffix}" for suffix in SUFFIXES)
    return next((place for place in places if place.is_file()), None)


def google(segments: list) -> list[Word]:
    """Return the words of GENEA 2020's JSON: first alternatives of segments, times such as "0.400s" (reference D.3)."""
    words = [word for segment in segments for word in (segment.get("alternatives") or [{}])[0].get("words", ())]
    return [(word["word"], float(word["start_time"].rstrip("s")), float(word["end_time"].rstrip("s"))) for word in words]


def table(path: Path) -> list[Word]:
    """Return the words of a GENEA 2022 or 2023 table: lines of start, end and text; words of a line share its time equally."""
    if path.stat().st_size > LARGEST:
        raise ValueError(f"it is larger than {LARGEST // 1_000_000} MB")
    words: list[Word] = []
    for line in read_bytes(path).decode("utf-8-sig").splitlines():
        start, end, text = (line.split("\t") + ["", ""])[:3]
        parts = [word for word in text.split() if any(sign.isalnum() for sign in word)]
        if not parts:
            continue
        begin, length = float(start), (float(end) - float(start)) / len(parts)
        words += [(word, begin + at * length, begin + (at + 1) * length) for at, word in enumerate(parts)]
    return words


def textgrid(path: Path) -> list[Word]:
    """Return the words of the tier "words" (else the first) of a long-form TextGrid; empty intervals are pauses."""
    raw = read_bytes(path)
    text = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    tiers = re.split(r"item\s*\[\d+\]\s*:", text)[1:]
    if not tiers:
        raise ValueError("it holds no tiers")
    tier = next((tier for tier in tiers if re.search(r'name\s*=\s*"words?"', tier, re.IGNORECASE)), tiers[0])
    words = [(match[2].replace('""', '"').strip(), float(match[0]), float(match[1])) for match in _INTERVAL.findall(tier)]
    return [word for word in words if word[0] and not word[0].startswith("<")]


def _timed(entries: Iterable[Sequence]) -> list[Word]:
    """Convert entries (text, start, end); raises ``ValueError`` for times that are not finite."""
    words = [(str(word), float(start), float(end)) for word, start, end in entries]
    if not np.isfinite([times for _, *times in words]).all():
        raise ValueError("a time is no number")
    return words


def _is_google(content: object) -> bool:
    return isinstance(content, list) and all(isinstance(segment, dict) for segment in content)
