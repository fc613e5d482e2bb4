"""What all readers share: the files of a performance, its split, and the report on skipped recordings."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from ...errors import CorpusUnreadable

TENTHS = ("train",) * 8 + ("validation", "test")
LARGEST_TABLE = 10_000_000
"""Most bytes of a table of recordings; BEAT2 has 1,762 rows."""
Report = Callable[[str], None]


@dataclass(frozen=True)
class PerformanceFiles:
    """The files of one performance, before they are read."""

    name: str
    motion: Path
    sound: Path
    words: Path | None
    speaker: str
    split: str


def ignore(_sentence: str) -> None:
    """Ignore a sentence."""


def split_of(name: str) -> str:
    """Return the split of a recording by its name alone: eight tenths training, a tenth each validation and test."""
    return TENTHS[int(hashlib.sha256(name.encode()).hexdigest(), 16) % 10]


def report_skipped(names: list[str], lack: str, tell: Report) -> None:
    """Report the recordings that are skipped because they have ``lack``, such as "no sound"."""
    if names:
        named = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        tell(f"Recordings with {lack} are left out ({len(names)}): {named}.")


def data_folder(folder: str | PathLike) -> Path:
    """Return a data set's folder; raises :class:`CorpusUnreadable` if it does not exist."""
    folder = Path(folder)
    if not folder.is_dir():
        raise CorpusUnreadable(f"There is no folder {folder}.", "Check the name.")
    return folder


def require_some(performances: list[PerformanceFiles], folder: Path, wanted: str) -> list[PerformanceFiles]:
    """Return the performances; raises :class:`CorpusUnreadable` if there are none."""
    if not performances:
        raise CorpusUnreadable(f"{folder} holds no performance: there is no {wanted}.", "Name the data set's top folder.")
    return performances
