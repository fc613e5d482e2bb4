"""Reads transcript files into pieces of text with the times that the file states; the format is detected by content.

Plain text; SRT, WebVTT, ASS subtitles; Praat TextGrids; JSON of Whisper, whisper.cpp, WhisperX, Google, GENEA, Gentle, the
Montreal Forced Aligner, Vosk, Amazon, Deepgram and our own ``[word, start, end]``; NIST CTM; labels in columns
(Audacity, GENEA, MFA, Whisper).
Every reader raises :class:`TranscriptUnreadable` for files that it cannot read."""

import re
from pathlib import Path

from ...errors import EngineMissing, TranscriptUnreadable
from .items import Item, Source

_CUE = re.compile(r"^\s*(?:\d+:)?\d+:\d\d[,.]\d+\s*-->\s*(?:\d+:)?\d+:\d\d[,.]\d+", re.MULTILINE)


def parse(content: str, path: Path) -> Source:
    """Parse a transcript; ``path`` is used in error messages, and its suffix where the content is ambiguous."""
    from . import columns, jsons

    head = content.lstrip("\ufeff \t\r\n")
    if path.suffix.lower() == ".json" or re.match(r'[\[{]\s*(["\[{]|[\]}]\s*$)', head):
        source = jsons.parse(content, path)
    elif "ootextfile" in head[:200].lower() and "textgrid" in head[:400].lower():  # Praat's
        source = _textgrid(content, path)
    elif (form := subtitle_format(head)) is not None:
        source = _subtitles(content, form, path)
    elif (form := columns.detect(content)) is not None:
        source = columns.parse(content, form, path)
    elif head.startswith(("<?xml", "<tt", "<!DOCTYPE")):
        raise TranscriptUnreadable(f"{path} is XML, which is not read.", "Export it as SRT, WebVTT or plain text.")
    else:
        return Source("plain text", [Item(content)])
    return Source(source.form, _sort(source.items))


def subtitle_format(head: str) -> str | None:
    """Return the format of subtitles, ``vtt``, ``srt`` or ``ass``, or None for another text."""
    if head.startswith("WEBVTT"):
        return "vtt"
    if head.startswith("[Script Info]"):
        return "ass"
    return "srt" if _CUE.search(head[:5000]) else None


def _textgrid(content: str, path: Path) -> Source:
    try:
        from .textgrid import parse
    except ModuleNotFoundError as error:  # that package, or in the extension's zip our module
        raise EngineMissing.of(ModuleNotFoundError(name="praatio")) from error
    return parse(content, path)


def _subtitles(content: str, form: str, path: Path) -> Source:
    try:
        from .subtitles import parse
    except ModuleNotFoundError as error:  # as above
        raise EngineMissing.of(ModuleNotFoundError(name="pysubs2")) from error
    return parse(content, form, path)


def _sort(items: list[Item]) -> list[Item]:
    """Drop items without text, and sort by time if all have one."""
    texts = [item for item in items if item.text.strip()]
    if all(item.start is not None for item in texts):
        texts.sort(key=lambda item: item.start or 0.0)
    return texts
