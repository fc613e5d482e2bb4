"""Which clips a participant sees, and in which order: balanced, shuffled, and without names that tell. numpy alone."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import UsageError

CLIPS = (".mp4", ".webm")


@dataclass(frozen=True)
class Design:
    """``clips[condition][excerpt]`` are files; ``names`` of them what the page calls them, by (condition, excerpt)."""

    conditions: tuple[str, ...]
    excerpts: tuple[str, ...]
    clips: dict[tuple[str, str], Path]
    names: dict[tuple[str, str], str]
    seed: int

    def order(self, participant: int) -> list[tuple[str, str]]:
        """(condition, excerpt) of every clip for the ``participant`` (from 0), excerpt by excerpt.

        Excerpts are shuffled for everyone anew. Within an excerpt the conditions follow a row of a Williams square, so that
        over participants and excerpts each stands in each place, and before each other one, equally often.
        """
        random = np.random.default_rng((self.seed, participant))
        square = williams(len(self.conditions))
        shuffled = random.permutation(len(self.excerpts))
        return [
            (self.conditions[condition], self.excerpts[number])
            for number in shuffled
            for condition in square[(participant + number) % len(square)]
        ]


def find(folder: str | PathLike, seed: int = 0) -> Design:
    """The design of ``folder``, which holds a folder for every condition with the same clips in each.

    Raises :class:`UsageError` where conditions or clips are missing.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise UsageError(f"There is no folder {folder}.", "Give one with a folder of clips for every condition.")
    found = {}
    for place in sorted(path for path in folder.iterdir() if path.is_dir()):
        clips = {path.stem: path for path in sorted(place.iterdir()) if path.suffix.lower() in CLIPS}
        if clips:
            found[place.name] = clips
    if len(found) < 2:
        raise UsageError(f"{folder} holds clips of {len(found)} conditions.", "A study compares two or more, a folder each.")
    excerpts = sorted(set().union(*found.values()))
    for condition, clips in found.items():
        missing = [excerpt for excerpt in excerpts if excerpt not in clips]
        if missing:
            message = f"{folder / condition} has no clip {missing[0]}"
            raise UsageError(f"{message}, which other conditions have.", "Give every condition the same clips.")
    clips = {(condition, excerpt): found[condition][excerpt] for condition in found for excerpt in excerpts}
    names = {key: f"{_digest(seed, *key)}{path.suffix.lower()}" for key, path in clips.items()}
    return Design(tuple(found), tuple(excerpts), clips, names, seed)


def williams(count: int) -> list[list[int]]:
    """Rows in which each of ``count`` conditions stands in each place equally often, and after each other one equally often.

    ``count`` rows for even numbers, twice as many for odd ones (Williams 1949).
    """
    first = [0]
    for step in range(1, count):
        first.append((step + 1) // 2 if step % 2 else count - step // 2)
    rows = [[(place + shift) % count for place in first] for shift in range(count)]
    return rows if count % 2 == 0 else rows + [row[::-1] for row in rows]


def _digest(seed: int, *parts: Sequence[str]) -> str:
    return hashlib.sha256("\0".join([str(seed), *parts]).encode()).hexdigest()[:12]
