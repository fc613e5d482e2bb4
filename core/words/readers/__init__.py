"""Reads transcript files into pieces of text with the times that the file states; the format is detected by content.

Plain text; SRT, WebVTT, ASS subtitles; Praat TextGrids; JSON of Whisper, whisper.cpp, WhisperX, Google, GENEA, Gentle, the
Montreal Forced Aligner, Vosk, Amazon, Deepgram and our own ``[word, start, end]``; NIST CTM; labels in columns
(Audacity, GENEA, MFA, Whisper).
Every reader raises :class:`TranscriptUnreadable` for files that it cannot read."""

import re
from pathlib import Path

from ...errors import TranscriptUnreadable
from .items import Item, Source


def parse(content: str, path: Path) -> Source:
    """Parse a transcript; ``path`` is used in error messages, and its suffix where the content is ambiguous."""
    from . import columns, jsons, subtitles, textgrid

    head = content.lstrip("\ufeff \t\r\n")
    if path.suffix.lower() == ".json" or re.match(r'[\[{]\s*(["\[{]|[\]}]\s*$)', head):
        source = jsons.parse(content, path)
    elif textgrid.is_textgrid(head):
        source = textgrid.parse(content, path)
    elif (form := subtitles.detect(head)) is not None:
        source = subtitles.parse(content, form, path)
    elif (form := columns.detect(content)) is not None:
        source = columns.parse(content, form, path)
    elif head.startswith(("<?xml", "<tt", "<!DOCTYPE")):
        raise TranscriptUnreadable(f"{path} is XML, which is not read.", "Export it as SRT, WebVTT or plain text.")
    else:
        return Source("plain text", [Item(content)])
    return Source(source.form, _sort(source.items))


def _sort(items: list[Item]) -> list[Item]:
    """Drop items without text, and sort by time if all have one."""
    texts = [item for item in items if item.text.strip()]
    if all(item.start is not None for item in texts):
        texts.sort(key=lambda item: item.start or 0.0)
    return texts
