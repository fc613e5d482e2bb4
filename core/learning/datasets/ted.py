"""TED Gesture as it is published: LMDB folders of videos that pyarrow serialised (reference sections B and D.1)."""

from collections import Counter
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable, UsageError
from ...motion import skeleton
from ...motion.readers.ten_joints import FARTHEST, resample
from ...sound.audio import SAMPLE_RATE
from . import lmdb_file, serialised
from .found import Tell, silent, tenth
from .recording import Recording

PARTS = {"train": "train", "val": "validation", "test": "test"}
SPLITS = ("original", "talk")
LONGEST = 3600.0
"""Seconds of a clip, which has ten."""
_UNWANTED = ("skeletons", "audio_feat")
"""What nobody needs of a clip: joints in the picture and a spectrogram."""


class _Odd(ValueError):
    """Why one clip is left out."""


def recordings(
    folder: str | PathLike, split: str = "original", tell: Tell = silent, fps: float = skeleton.FPS
) -> Iterator[Recording]:
    """One recording a clip, ``fps`` poses a second; the speaker is the video.

    ``tell(sentence)`` hears at the end what was left out and why.

    ``split`` "original" keeps the data set's, in which every talk lies in all three parts; "talk" gives whole talks to one
    part each, so that no test talk was heard in training. Raises :class:`CorpusUnreadable`.
    """
    if split not in SPLITS:
        raise UsageError(f"There is no split {split!r}.", f"Splits are {', '.join(SPLITS)}.")
    folder = Path(folder)
    named = ((part, folder / name) for part in PARTS for name in (f"lmdb_{part}", part))
    parts = [(part, place) for part, place in named if (place / "data.mdb").is_file()]
    if not parts:
        message = f"{folder} holds no lmdb_train, lmdb_val or lmdb_test with a data.mdb."
        raise CorpusUnreadable(message, "Unpack TED Gesture and name its top folder.")
    odd: Counter[str] = Counter()
    for part, place in parts:
        yield from _videos(place, PARTS[part] if split == "original" else None, odd, fps)
    for reason, count in odd.most_common():
        tell(f"Clips {reason} are left out ({count}).")


def _videos(place: Path, split: str | None, odd: Counter, fps: float) -> Iterator[Recording]:
    name = b""
    try:
        for key, value in lmdb_file.records(place):
            name = key
            video = serialised.read(value, _UNWANTED)
            for number, clip in enumerate(video["clips"]):
                try:
                    yield _clip(str(video["vid"]), number, clip, split, fps)
                except _Odd as reason:
                    odd[str(reason)] += 1
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        where = f"Record {name.decode('ascii', 'replace')[:20]} of {place}"
        raise CorpusUnreadable(f"{where} is no video of TED Gesture: {reason}.", "Download it again.") from error


def _clip(vid: str, number: int, clip: dict, split: str | None, fps: float) -> Recording:
    """Ten joints a video frame to directions at ``fps`` frames a second; word times count from the clip's start."""
    begin, end = float(clip["start_time"]), float(clip["end_time"])
    sound = np.asarray(clip["audio_raw"], float)
    try:
        poses = np.asarray(clip["skeletons_3d"], float)
    except ValueError:
        raise _Odd("with poses of uneven shape") from None
    if poses.ndim == 3 and len(poses) and poses.shape[1:] != (len(skeleton.JOINTS), 3):
        raise _Odd(f"with {poses.shape[1]} joints, not TED Gesture's ten,")
    if not 0 < end - begin < LONGEST or poses.ndim != 3 or not len(poses) or sound.ndim != 1:
        raise _Odd("without time, poses or sound")
    if not ((np.abs(poses) <= FARTHEST).all() and (np.abs(sound) <= FARTHEST).all()):
        raise _Odd("with values that are no numbers")
    poses, sound, duration = poses.astype(np.float32), sound.astype(np.float32), end - begin
    directions = resample(skeleton.to_directions(poses), len(poses) / duration, fps)
    wanted = int(round(duration * SAMPLE_RATE))
    audio = np.pad(sound[:wanted], (0, max(wanted - len(sound), 0))) / max(float(np.abs(sound).max(initial=0)), 1.0)
    words = [(str(word), float(a) - begin, float(b) - begin) for word, a, b in clip["words"]]
    return Recording(f"{vid}-{number}", audio, words, directions, vid, split or tenth(vid))
