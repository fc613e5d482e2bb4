"""What is said and when: from plain text by alignment, from a JSON of timed words as it is, or from nothing."""

import json
import re
from os import PathLike
from pathlib import Path

import numpy as np

from .align import align
from .audio import SAMPLE_RATE
from .errors import TranscriptUnreadable, UsageError
from .spelling import spoken

Word = tuple[str, float, float]

_LONGEST = 10_000_000
"""Bytes: no transcript is longer, and a recording named by mistake usually is."""
_DIRECTIONS = re.compile(r"\[[^\[\]\n]{0,200}\]|<[^<>\n]{0,200}>|\{[^{}\n]{0,200}\}|\*[^*\n]{1,60}\*(?=\W|$)|♪+")
_EDGES = re.compile(r"^[^\w$€£'’&%+-]+|[^\w'’%]+$")


def resolve(
    audio: np.ndarray, transcript: str | PathLike | None = None, text: str | None = None, progress=None
) -> tuple[tuple[Word, ...], list[str]]:
    """``(word, start, end)`` in seconds for a recording ``(n,)`` at 16 kHz, and warnings for people.

    ``transcript`` is a file: plain text, which is aligned, or ``.json`` with times; ``text`` is the text itself; with
    neither, or with an empty one, the audio gestures alone. ``progress`` is called with 0..1 during alignment. Raises
    :class:`TranscriptUnreadable` and, when both are given, :class:`UsageError`.
    """
    if transcript is not None and text is not None:
        raise UsageError("A transcript file and a text were both given.", "Give one of them.")
    if transcript is None and text is None:
        return (), []
    if transcript is not None:
        content = read(transcript)
        if Path(transcript).suffix.lower() == ".json":
            return _within(timed(content, Path(transcript)), len(audio) / SAMPLE_RATE)
        text = content
    tokens = tokenise(text)
    if not tokens:
        return (), ["The transcript holds no words; the gestures follow the sound alone."]
    spans, warnings = align(audio, [said for _, said in tokens], progress)
    return tuple((shown, start, end) for (shown, _), (start, end) in zip(tokens, spans, strict=True)), warnings


def read(path: str | PathLike) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, else Windows-1252. Raises :class:`TranscriptUnreadable`."""
    path = Path(path)
    if path.is_dir():
        raise TranscriptUnreadable(f"{path} is a folder, not a transcript.", "Name a .txt or .json file inside it.")
    try:
        with open(path, "rb") as file:
            data = file.read(_LONGEST + 1)
    except FileNotFoundError:
        raise TranscriptUnreadable(f"The transcript {path} does not exist.", "Check the name and the folder.") from None
    except OSError as error:
        raise TranscriptUnreadable(f"{path} cannot be read: {error.strerror}.", "Check the file's permissions.") from error
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") and len(data) % 2 == 0:
        encodings = ("utf-16",)
    else:
        encodings = ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError:
            text = "\0"
    if "\0" in text or len(data) > _LONGEST:
        raise TranscriptUnreadable(f"{path} is not a text file.", "Give the words as plain text (.txt) or timed words (.json).")
    return text


def tokenise(text: str) -> list[tuple[str, list[str]]]:
    """Words as ``(as written, [as spoken, ...])``: without punctuation and stage directions like ``[laughs]``."""
    text = re.sub(r"(?<=[^\W\d])(?:[–—…]+|--+|\.{2,})(?=\w)", " ", _DIRECTIONS.sub(" ", text))
    tokens = [(_EDGES.sub("", piece), spoken(piece)) for piece in text.split()]
    return [(shown, said) for shown, said in tokens if shown and said]


def timed(content: str, path: Path) -> tuple[Word, ...]:
    """Timed words of a JSON text: a list, or ``{"words": list}``, of ``[word, start, end]`` or objects with these keys."""
    remedy = 'Write [["hello", 0.31, 0.62], ...] with times in seconds, or plain text.'
    try:
        data = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise TranscriptUnreadable(f"{path} is not valid JSON.", remedy) from error
    entries = data.get("words") if isinstance(data, dict) else data
    if not isinstance(entries, list):
        raise TranscriptUnreadable(f"{path} holds no list of words.", remedy)
    words = []
    for number, entry in enumerate(entries, 1):
        fields = [entry.get(key) for key in ("word", "start", "end")] if isinstance(entry, dict) else entry
        if not _is_word(fields):
            raise TranscriptUnreadable(f"Entry {number} of {path} is not a word with start and end in seconds.", remedy)
        words.append((fields[0].strip(), float(fields[1]), float(fields[2])))
    return tuple(sorted((word for word in words if word[0]), key=lambda word: word[1]))


def _is_word(fields) -> bool:
    if not isinstance(fields, list) or len(fields) != 3 or not isinstance(fields[0], str):
        return False
    numbers = all(isinstance(time, int | float) and not isinstance(time, bool) for time in fields[1:])
    return numbers and 0 <= fields[1] <= fields[2] < 1e9


def _within(words: tuple[Word, ...], duration: float) -> tuple[tuple[Word, ...], list[str]]:
    """Drop words that begin after the recording has ended, and say so."""
    kept = tuple((word, start, min(end, duration)) for word, start, end in words if start < duration)
    if not words:
        return (), ["The transcript holds no words; the gestures follow the sound alone."]
    if len(kept) == len(words):
        return kept, []
    return kept, [f"{len(words) - len(kept)} words of the transcript lie after the end of the recording and are left out."]
