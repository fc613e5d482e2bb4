"""Reads Praat's TextGrid, in its long and short format, with praatio."""

import re
from pathlib import Path

from praatio.utilities.textgrid_io import parseTextgridStr

from ...errors import TranscriptUnreadable
from .items import Item, Source, parse_times

_WORDS = re.compile(r"(?:.*[\s_:-])?(?:words?|ort|orthography|orthographic)", re.IGNORECASE)
_PHONES = re.compile(r"(?:.*[\s_:-])?(?:phones?|phonemes?|segments?|mau|syllables?|pitch|tones?)", re.IGNORECASE)
_SILENT = {"", "sil", "sp", "spn", "<eps>", "<sil>", "#", "<p:>", "..."}


def parse(content: str, path: Path) -> Source:
    """Parse the tier of words, else the one with the most text that does not look like phones.

    Raises :class:`TranscriptUnreadable`."""
    try:
        tiers = parseTextgridStr(content.replace("\r\n", "\n").lstrip("\ufeff"), includeEmptyIntervals=False)["tiers"]
        intervals = {
            tier["name"]: [tuple(entry) for entry in tier["entries"]] for tier in tiers if tier["class"] == "IntervalTier"
        }
    except Exception as error:  # praatio parses by index and does not catch the errors of that
        raise TranscriptUnreadable(f"{path} is a damaged TextGrid.", "Save it again in Praat.") from error
    entries = intervals.get(_choose(intervals), [])
    items = []
    for number, entry in enumerate(entries, 1):
        span = parse_times(*entry[:2]) if len(entry) == 3 else None
        if span is None:
            raise TranscriptUnreadable(f"Interval {number} of {path} has no sensible time.", "Save it again in Praat.")
        text = str(entry[2]).strip()
        if text.lower() not in _SILENT:
            items.append(Item(text, *span, word=len(text.split()) == 1))
    if not intervals:
        raise TranscriptUnreadable(f"{path} has no tier of intervals.", "Put the words into an interval tier named words.")
    return Source("TextGrid", items)


def _choose(tiers: dict[str, list]) -> str:
    """Return the name of the tier of words, "" if there are no tiers."""
    for name in tiers:
        if _WORDS.fullmatch(name):
            return name
    plain = [name for name in tiers if not _PHONES.fullmatch(name)] or list(tiers)
    return max(plain, key=lambda name: sum(len(str(entry[-1])) for entry in tiers[name]), default="")
