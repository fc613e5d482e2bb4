"""The transcript that a recording brings along."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

SUFFIXES = (".txt", ".srt", ".vtt", ".TextGrid")
"""Of transcripts that are found by themselves, in this order."""


def beside(recording: str | PathLike, there: Callable[[Path], bool] = Path.is_file) -> Path | None:
    """The transcript of the recording's name in its folder, by the first of :data:`SUFFIXES` that is ``there``."""
    recording = Path(recording)
    try:
        named = [recording.with_suffix(suffix) for suffix in SUFFIXES]
        return next((path for path in named if path != recording and there(path)), None)
    except (OSError, ValueError):
        return None  # a name that no file can have: whoever reads the recording will say so
