"""What a reader has found before anything is read, and what it says of what it leaves out."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from ...errors import CorpusUnreadable

TENTHS = ("train",) * 8 + ("validation", "test")
LARGEST_TABLE = 10_000_000
"""Bytes of a table of recordings; BEAT2 has 1,762 rows."""
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Found:
    """The files of one performance, before they are read."""

    name: str
    motion: Path
    sound: Path
    words: Path | None
    speaker: str
    split: str


def silent(_sentence: str) -> None:
    """Nobody wants to hear."""


def tenth(name: str) -> str:
    """The split of a recording by its name alone: eight tenths train, a tenth each validate and test."""
    return TENTHS[int(hashlib.sha256(name.encode()).hexdigest(), 16) % 10]


def left_out(names: list[str], lack: str, tell: Tell) -> None:
    """Say which recordings are not read because they have ``lack``."""
    if names:
        named = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        tell(f"Recordings with {lack} are left out ({len(names)}): {named}.")


def top(folder: str | PathLike) -> Path:
    """The data set's folder; raises :class:`CorpusUnreadable` where there is none."""
    folder = Path(folder)
    if not folder.is_dir():
        raise CorpusUnreadable(f"There is no folder {folder}.", "Check the name.")
    return folder


def some(found: list[Found], folder: Path, wanted: str) -> list[Found]:
    """``found``; raises :class:`CorpusUnreadable` where nothing was found."""
    if not found:
        raise CorpusUnreadable(f"{folder} holds no performance: there is no {wanted}.", "Name the data set's top folder.")
    return found
