"""Transcripts in the forms people have: recognised by their content, read into pieces of text with the times that they state.

Plain text; SRT, WebVTT, ASS subtitles; Praat TextGrids; JSON of Whisper, whisper.cpp, WhisperX, Google, GENEA, Gentle, the
Montreal Forced Aligner, Vosk, Amazon, Deepgram and our own ``[word, start, end]``; NIST CTM; labels in columns
(Audacity, GENEA, MFA, Whisper).
Every reader raises :class:`TranscriptUnreadable` in one sentence for what it cannot read.
"""

import re
from pathlib import Path

from ...errors import TranscriptUnreadable
from .items import Item, Source


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
