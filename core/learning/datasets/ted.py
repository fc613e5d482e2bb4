"""TED Gesture from the folder that :mod:`ted_export` writes (reference sections B and D.1)."""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ... import json_text, npz
from ...errors import CorpusUnreadable, UsageError
from ...motion import skeleton
from ...sound.audio import SAMPLE_RATE
from .found import Tell, tenth
from .recording import Recording
from .ten import FARTHEST, resample

PARTS = {"train": "train", "val": "validation", "test": "test"}
SPLITS = ("original", "talk")
LARGEST, LONGEST = 4_000_000_000, 3600.0
"""Bytes that a video's arrays may unpack to, and seconds of a clip, which has ten."""


def recordings(folder: str | PathLike, split: str = "original", tell: Tell = lambda name: None) -> Iterator[Recording]:
    """One recording a clip; the speaker is the video.

    ``split`` "original" keeps the data set's, in which every talk lies in all three parts; "talk" gives whole talks to one
    part each, so that no test talk was heard in training. Raises :class:`CorpusUnreadable`.
    """
    if split not in SPLITS:
        raise UsageError(f"There is no split {split!r}.", f"Splits are {', '.join(SPLITS)}.")
    folder = Path(folder)
    files = [(part, path) for part in PARTS for path in sorted((folder / part).glob("*.json"))]
    if not files:
        message = f"{folder} holds no exported videos (train/*.json)."
        raise CorpusUnreadable(
            message, "Export the LMDB first with core/learning/datasets/ted_export.py in an old environment."
        )
    for part, path in files:
        tell(path.stem)
        yield from _video(path, PARTS[part] if split == "original" else None)


def _video(path: Path, split: str | None) -> Iterator[Recording]:
    try:
        video = json_text.read(path)
        with npz.opened(path.with_suffix(".npz"), LARGEST) as arrays:
            for number, clip in enumerate(video["clips"]):
                poses, sound = arrays[f"{number}.skeletons_3d"], arrays[f"{number}.audio_raw"]
                yield _clip(video["vid"], number, clip, np.asarray(poses, np.float32), np.asarray(sound, np.float32), split)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        raise CorpusUnreadable(f"{path} is no exported video: {reason}.", "Export the LMDB again.") from error


def _clip(vid: str, number: int, clip: dict, poses: np.ndarray, sound: np.ndarray, split: str | None) -> Recording:
    """Ten joints a video frame to directions at 15 frames a second; word times count from the clip's start."""
    begin, end = float(clip["start_time"]), float(clip["end_time"])
    if not 0 < end - begin < LONGEST:
        raise ValueError(f"clip {number} lasts {end - begin:g} s")
    if poses.ndim != 3 or poses.shape[1:] != (len(skeleton.JOINTS), 3):
        raise ValueError(f"clip {number} has poses of shape {poses.shape}")
    if not ((np.abs(poses) <= FARTHEST).all() and np.isfinite(sound).all() and sound.ndim == 1):
        raise ValueError(f"clip {number} holds values that are no numbers")
    duration = end - begin
    directions = resample(skeleton.to_directions(poses), len(poses) / duration)
    wanted = int(round(duration * SAMPLE_RATE))
    audio = np.pad(sound[:wanted], (0, max(wanted - len(sound), 0))) / max(float(np.abs(sound).max(initial=0)), 1.0)
    words = [(str(word), float(a) - begin, float(b) - begin) for word, a, b in clip["words"]]
    return Recording(f"{vid}-{number}", audio, words, directions, vid, split or tenth(vid))
