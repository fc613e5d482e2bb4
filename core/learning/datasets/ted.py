"""Reads TED Gesture as published: LMDB folders of videos, serialised by pyarrow (reference sections B and D.1)."""

from collections import Counter
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import cast

import numpy as np

from ...errors import CorpusUnreadable, UsageError
from ...motion import skeleton
from ...motion.readers.ten_joints import FARTHEST
from ...sound.audio import SAMPLE_RATE
from . import lmdb_file, pyarrow_serialized
from .listing import Report, ignore, split_of
from .recording import Recording
from .resampling import resample

PARTS = {"train": "train", "val": "validation", "test": "test"}
SPLITS = ("original", "talk")
LONGEST = 3600.0
"""Most seconds of a clip, which usually has ten."""
_UNWANTED = ("skeletons", "audio_feat")
"""Parts of a clip that are not read: 2D joints and a spectrogram."""


class _SkippedClip(ValueError):
    """The reason why a clip is skipped."""


def recordings(
    folder: str | PathLike, split: str = "original", tell: Report = ignore, fps: float = skeleton.FPS
) -> Iterator[Recording]:
    """Yield one recording per clip with ``fps`` poses per second; the speaker is the video.

    ``tell(sentence)`` is called at the end with the reasons and counts of skipped clips. ``split`` "original" is that of the
    data set, in which every talk is in all three parts; "talk" assigns whole talks to one part each, so that no test talk is
    in training. Raises :class:`CorpusUnreadable`.
    """
    if split not in SPLITS:
        raise UsageError(f"There is no split {split!r}.", f"Splits are {', '.join(SPLITS)}.")
    folder = Path(folder)
    named = ((part, folder / name) for part in PARTS for name in (f"lmdb_{part}", part))
    parts = [(part, place) for part, place in named if (place / "data.mdb").is_file()]
    if not parts:
        message = f"{folder} holds no lmdb_train, lmdb_val or lmdb_test with a data.mdb."
        raise CorpusUnreadable(message, "Unpack TED Gesture and name its top folder.")
    skipped: Counter[str] = Counter()
    for part, place in parts:
        yield from _videos(place, PARTS[part] if split == "original" else None, skipped, fps)
    for reason, count in skipped.most_common():
        tell(f"Clips {reason} are left out ({count}).")


def _videos(place: Path, split: str | None, skipped: Counter[str], fps: float) -> Iterator[Recording]:
    """Yield the clips of a folder's videos, counting the reasons of ``skipped`` ones."""
    name = b""
    try:
        for key, value in lmdb_file.records(place):
            name = key
            video = cast(dict, pyarrow_serialized.read(value, _UNWANTED))  # another kind raises a TypeError below
            for number, clip in enumerate(video["clips"]):
                try:
                    yield _clip(str(video["vid"]), number, clip, split, fps)
                except _SkippedClip as reason:
                    skipped[str(reason)] += 1
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        where = f"Record {name.decode('ascii', 'replace')[:20]} of {place}"
        raise CorpusUnreadable(f"{where} is no video of TED Gesture: {reason}.", "Download it again.") from error


def _clip(vid: str, number: int, clip: dict, split: str | None, fps: float) -> Recording:
    """Convert a clip: ten joints per video frame to directions at ``fps``, and word times to those from its start."""
    begin, end = float(clip["start_time"]), float(clip["end_time"])
    sound = np.asarray(clip["audio_raw"], float)
    try:
        poses = np.asarray(clip["skeletons_3d"], float)
    except ValueError:
        raise _SkippedClip("with poses of uneven shape") from None
    if poses.ndim == 3 and len(poses) and poses.shape[1:] != (len(skeleton.JOINTS), 3):
        raise _SkippedClip(f"with {poses.shape[1]} joints, not TED Gesture's ten,")
    if not 0 < end - begin < LONGEST or poses.ndim != 3 or not len(poses) or sound.ndim != 1:
        raise _SkippedClip("without time, poses or sound")
    if not ((np.abs(poses) <= FARTHEST).all() and (np.abs(sound) <= FARTHEST).all()):
        raise _SkippedClip("with values that are no numbers")
    poses, sound, duration = poses.astype(np.float32), sound.astype(np.float32), end - begin
    directions = resample(skeleton.to_directions(poses), len(poses) / duration, fps)
    samples = int(round(duration * SAMPLE_RATE))
    audio = np.pad(sound[:samples], (0, max(samples - len(sound), 0))) / max(float(np.abs(sound).max(initial=0)), 1.0)
    words = [(str(word), float(a) - begin, float(b) - begin) for word, a, b in clip["words"]]
    return Recording(f"{vid}-{number}", audio, words, directions, vid, split or split_of(vid))
