"""Finds the transcript that lies next to a recording."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

SUFFIXES = (".txt", ".srt", ".vtt", ".TextGrid")
"""Suffixes of transcripts that are found automatically, in this order."""


def find_transcript(recording: str | PathLike, there: Callable[[Path], bool] = Path.is_file) -> Path | None:
    """Return the file next to the recording that has its name and the first suffix of :data:`SUFFIXES` that exists, or None.

    ``there`` tells whether a path exists."""
    recording = Path(recording)
    try:
        candidates = [recording.with_suffix(suffix) for suffix in SUFFIXES]
        return next((path for path in candidates if path != recording and there(path)), None)
    except (OSError, ValueError):
        return None  # an invalid file name: reading the recording will report it


def words_beside(recording: str | PathLike, there: Callable[[Path], bool] = Path.is_file) -> dict[str, str]:
    """Return the setting that names the transcript found by :func:`find_transcript`, {} where there is none."""
    path = find_transcript(recording, there)
    return {"transcript": str(path)} if path else {}
