"""Decodes films to pictures with times, upright and no larger than an estimator needs; finds cuts."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import CorpusUnreadable
from ...files import open_file
from ...sound.av_decoding import open_container

if TYPE_CHECKING:
    from av.container import InputContainer

LARGEST = 960
"""Pixels of the longer side of a picture: estimators scale what they are given to 256."""
MOST_RATE = 31.0
"""Pictures a second that are looked at; of films with more, every second one is."""
SUFFIXES = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v", ".mpg", ".mpeg", ".3gp", ".ogv")
_THUMBNAIL = 24
CUT, _CUT_RATIO = 0.10, 3.0
"""A cut changes a thumbnail's pixels by more than this share of white, and so many times as much as pictures around."""
_BRIGHT = 130.0
"""Brightness, of 255, below which the brightest part of a picture calls for more."""
_MAX_SECONDS = 4 * 3600.0


@dataclass(frozen=True)
class Facts:
    """Size of the pictures as they are shown, and the film's length in seconds (0 where it is unknown)."""

    width: int
    height: int
    seconds: float


@dataclass(frozen=True)
class Picture:
    """An upright picture ``(height, width, 3)`` uint8 RGB, and its time in seconds."""

    time: float
    pixels: np.ndarray


def facts(path: str | PathLike) -> Facts:
    """Return a film's facts; raises :class:`CorpusUnreadable`."""
    for picture in pictures(path):
        height, width = picture.pixels.shape[:2]
        with _container(Path(path)) as container:
            return Facts(width, height, float(container.duration or 0) / 1_000_000)
    raise CorpusUnreadable(f"{path} holds no picture.", "Choose another film.")


def pictures(
    path: str | PathLike, rate: float = MOST_RATE, spans: Sequence[tuple[float, float]] | None = None
) -> Iterator[Picture]:
    """Yield the pictures of a film at ``rate`` a second at most, of ``spans`` (start, end) in seconds alone if there are any.

    Raises :class:`CorpusUnreadable`.
    """
    import av.error

    path, last, began, turns = Path(path), -1.0, None, None
    with _container(path) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        for packet in container.demux(stream):
            try:
                frames = packet.decode()
            except av.error.InvalidDataError:  # as in a player
                continue
            for frame in frames:
                if frame.time is None:
                    continue
                began = frame.time if began is None else began
                at = frame.time - began
                if at > _MAX_SECONDS:
                    raise CorpusUnreadable(f"{path} is longer than four hours.", "Cut it into parts.")
                if spans is not None and at > spans[-1][1]:
                    return
                if at - last < 0.999 / rate or (spans is not None and not any(a <= at <= b for a, b in spans)):
                    continue
                last = at
                turns = _quarter_turns(frame) if turns is None else turns
                yield Picture(at, np.ascontiguousarray(np.rot90(_pixels(frame), turns)))


def is_cut(changes: np.ndarray) -> np.ndarray:
    """Return where a new scene begins ``(n,)``, of how far each picture differs from the one before ``(n,)``."""
    padded = np.pad(changes, 3, mode="edge")
    around = np.stack([padded[3 + shift : len(padded) - 3 + shift] for shift in (-3, -2, -1, 1, 2, 3)])
    return (changes > CUT) & (changes > _CUT_RATIO * np.median(around, axis=0) + 0.02)


def thumbnail(pixels: np.ndarray) -> np.ndarray:
    """Return a small grey picture ``(24, 24)`` of 0..1."""
    rows, columns = (np.linspace(0, size - 1, 2 * _THUMBNAIL).astype(int) for size in pixels.shape[:2])
    small = pixels[np.ix_(rows, columns)].mean(-1) / 255
    return small.reshape(_THUMBNAIL, 2, _THUMBNAIL, 2).mean((1, 3))


def brightened(pixels: np.ndarray) -> np.ndarray:
    """Return dark pictures with the brightness of well lit ones, others as they are: estimators lose hands in the dark."""
    bright = float(np.percentile(pixels[::8, ::8].max(-1), 97))
    if not 8 < bright < _BRIGHT:
        return pixels
    table = np.clip(255 * (np.arange(256) / bright * 0.85).clip(0, 1) ** 0.8, 0, 255).astype(np.uint8)
    return table[pixels]


def _pixels(frame) -> np.ndarray:
    share = min(1.0, LARGEST / max(frame.width, frame.height))
    width, height = (max(round(size * share / 2) * 2, 2) for size in (frame.width, frame.height))
    return frame.to_ndarray(width=width, height=height, format="rgb24")


def _quarter_turns(frame) -> int:
    """Return by how many quarters to the left a telephone's picture is to be turned."""
    return round(getattr(frame, "rotation", 0) / 90) % 4


@contextlib.contextmanager
def _container(path: Path) -> "Iterator[InputContainer]":
    """Open a film; errors of ``av`` in the block become :class:`CorpusUnreadable`."""
    import av.error

    try:
        open_file(path).close()  # readers that open files by themselves would wait for a pipe
        with open_container(path) as container:
            if not container.streams.video or container.streams.video[0].codec_context is None:
                raise CorpusUnreadable(f"{path} has no picture that anything here reads.", "Choose a film.")
            yield container
    except (av.error.FFmpegError, OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise CorpusUnreadable(f"{path} is no readable film ({reason}).", "Export it again, for instance as MP4.") from error
