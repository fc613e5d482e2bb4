"""Reads JSON of speech recognisers and aligners, which are distinguished by their keys."""

from pathlib import Path
from typing import Any, TypeGuard

from ... import json_text
from ...errors import TranscriptUnreadable
from .items import Item, Source, parse_times

_REMEDY = 'Write [["hello", 0.31, 0.62], ...] with times in seconds, or plain text.'
_WORD = ("punctuated_word", "word", "text", "content", "label")
_START = ("start", "startTime", "start_time", "startOffset", "start_offset")
_END = ("end", "endTime", "end_time", "endOffset", "end_offset")


def parse(content: str, path: Path) -> Source:
    """Parse a JSON transcript. Raises :class:`TranscriptUnreadable`."""
    try:
        data = json_text.parse(content)
    except json_text.NotJson as error:
        raise TranscriptUnreadable(f"{path} is not valid JSON: {error}.", _REMEDY) from error
    for form, reader in _FORMS:
        items = reader(data, path)
        if items is not None:
            return Source(form, items)
    raise TranscriptUnreadable(f"{path} holds no list of words.", _REMEDY)


def _gentle(data: Any, path: Path) -> list[Item] | None:
    """Read Gentle, whose ``startOffset`` counts characters; words that it did not find have no times."""
    if not isinstance(data, dict) or "transcript" not in data or not _objects(data.get("words")):
        return None
    items = []
    for entry in data["words"]:
        if isinstance(entry.get("word"), str):
            span = parse_times(entry.get("start"), entry.get("end")) if entry.get("case") != "not-found-in-audio" else None
            items.append(Item(entry["word"], *(span or (None, None)), word=span is not None))
    return items


def _whisper(data: Any, path: Path) -> list[Item] | None:
    """Read Whisper, faster-whisper, WhisperX: segments, with or without words; in WhisperX numbers often have no times."""
    if not isinstance(data, dict) or not _objects(data.get("segments")):
        return None
    items = []
    for number, segment in enumerate(data["segments"], 1):
        if _objects(segment.get("words")):
            items += [_word(word, path, must=False) for word in segment["words"]]
        elif isinstance(segment.get("text"), str):
            items.append(
                _phrase(segment["text"], parse_times(segment.get("start"), segment.get("end")), f"Segment {number}", path)
            )
    return items


def _whisper_cpp(data: Any, path: Path) -> list[Item] | None:
    """Read whisper.cpp, whose ``offsets`` are milliseconds."""
    if not isinstance(data, dict) or not _objects(data.get("transcription")):
        return None
    items = []
    for number, segment in enumerate(data["transcription"], 1):
        offsets = segment.get("offsets")
        limits: list[Any] = [offsets.get("from"), offsets.get("to")] if isinstance(offsets, dict) else [None, None]
        numbers = all(isinstance(limit, int | float) for limit in limits)
        span = parse_times(*(limit / 1000 for limit in limits)) if numbers and max(map(abs, limits)) < 1e12 else None
        items.append(_phrase(segment.get("text"), span, f"Segment {number}", path))
    return items


def _google(data: Any, path: Path) -> list[Item] | None:
    """Read the first alternatives of results: Google Speech-to-Text, GENEA 2020 and, in channels, Deepgram."""
    results = data.get("results") if isinstance(data, dict) else data
    if isinstance(results, dict) and _objects(results.get("channels")):
        results = results["channels"][:1]
    if not _objects(results) or not all("alternatives" in result for result in results):
        return None
    items: list[Item] = []
    for result in results:
        if not _objects(result["alternatives"]):
            continue
        best = result["alternatives"][0]
        if _objects(best.get("words")):
            # with speaker labels the last result repeats all words
            words = [_word(word, path) for word in best["words"]]
            again = items and words and words[0].start is not None and words[0].start < (items[-1].start or 0)
            items = words if again else items + words
        elif isinstance(best.get("transcript"), str):
            items.append(Item(best["transcript"]))
    return items


def _amazon(data: Any, path: Path) -> list[Item] | None:
    """Read Amazon Transcribe: items, of which punctuation has no times."""
    results = data.get("results") if isinstance(data, dict) else None
    if not isinstance(results, dict) or not _objects(results.get("items")):
        return None
    items = []
    for entry in results["items"]:
        best = entry["alternatives"][0] if _objects(entry.get("alternatives")) and entry["alternatives"] else {}
        span = parse_times(entry.get("start_time"), entry.get("end_time"))
        if span and isinstance(best.get("content"), str):
            items.append(Item(best["content"], *span, word=True))
    return items


def _tiers(data: Any, path: Path) -> list[Item] | None:
    """Read the Montreal Forced Aligner and praatio: tiers of ``[start, end, label]``, by name or in a list."""
    tiers = data.get("tiers") if isinstance(data, dict) else None
    if _objects(tiers):
        tiers = {str(tier.get("name")): tier for tier in tiers}
    if not isinstance(tiers, dict) or not tiers:
        return None
    word_tiers = [name for name in tiers if name.lower().endswith(("words", "word"))] or list(tiers)[:1]
    items = []
    for name in word_tiers:
        entries = tiers[name].get("entries") if isinstance(tiers[name], dict) else None
        rows: list[Any] = entries if isinstance(entries, list) else []
        for number, entry in enumerate(rows, 1):
            span = parse_times(*entry[:2]) if isinstance(entry, list) and len(entry) == 3 else None
            if span is None or not isinstance(entry[2], str):
                where = f"Entry {number} of tier {name[:40]!r} of {path}"
                raise TranscriptUnreadable(f"{where} has no start, end and label.", _REMEDY)
            if entry[2].strip().lower() not in ("", "<eps>", "sil", "sp", "spn"):
                items.append(Item(entry[2], *span, word=len(entry[2].split()) == 1))
    return items


def _own(data: Any, path: Path) -> list[Item] | None:
    """Read lists of ``[word, start, end]`` or of objects, alone or as ``words`` or ``result`` (Vosk)."""
    entries = data
    if isinstance(data, dict):
        entries = data.get("words", data.get("result"))
    if not isinstance(entries, list):
        return None
    items = []
    for number, entry in enumerate(entries, 1):
        item = None
        if isinstance(entry, dict):
            item = _word(entry, path, must=False)
        elif isinstance(entry, list) and len(entry) == 3 and isinstance(entry[0], str) and _numbers(entry[1:]):
            span = parse_times(*entry[1:])
            item = span and Item(entry[0].strip(), *span, word=True)
        if not item or item.start is None:
            raise TranscriptUnreadable(f"Entry {number} of {path} is not a word with start and end in seconds.", _REMEDY)
        items.append(item)
    return items


def _word(entry: dict, path: Path, must: bool = True) -> Item:
    """Read a word from an object; with ``must`` the times are required, though Google leaves out zero."""
    text = next((entry[key] for key in _WORD if isinstance(entry.get(key), str)), None)
    start, end = (next((entry[key] for key in keys if key in entry), None) for keys in (_START, _END))
    if must and start is None and end is not None:
        start = 0.0  # Google leaves zeros out
    span = parse_times(start, end)
    if text is None or (must or start is not None) and span is None:
        raise TranscriptUnreadable(f"A word of {path} lacks its text or a sensible time.", _REMEDY)
    return Item(text.strip(), *(span or (None, None)), word=span is not None)


def _phrase(text: object, span: tuple[float, float] | None, what: str, path: Path) -> Item:
    """Make an item of a phrase, which needs text and times; ``what`` names it in the error."""
    if not isinstance(text, str) or span is None:
        raise TranscriptUnreadable(f"{what} of {path} lacks its text or a sensible time.", _REMEDY)
    return Item(text.strip(), *span)


def _objects(value: object) -> TypeGuard[list[dict]]:
    """Return whether the value is a non-empty list of objects."""
    return isinstance(value, list) and bool(value) and all(isinstance(entry, dict) for entry in value)


def _numbers(values: list) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


_FORMS = (
    ("JSON of Gentle", _gentle),
    ("JSON of Whisper", _whisper),
    ("JSON of whisper.cpp", _whisper_cpp),
    ("JSON of Google", _google),
    ("JSON of Amazon", _amazon),
    ("JSON of an aligner", _tiers),
    ("JSON of words", _own),
)
