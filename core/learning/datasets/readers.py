"""Folders of recorded performances: BEAT2, ZeroEGGS and plain folders of motion, sound and words; all readers by name."""

import csv
import io
import re
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from ...motion.readers import motion_files, smplx, ten_joints
from ...motion.skeleton import FPS
from ...sound import audio
from . import transcripts
from .found import LARGEST_TABLE, Found, Tell, left_out, silent, some, tenth, top
from .genea import genea, trinity
from .recording import Recording

SOUNDS = (".wav", ".flac", ".mp3", ".ogg", ".m4a")


def plain(folder: str | PathLike, speaker: str | None = None, tell: Tell = silent) -> list[Found]:
    """Motion files with sound of the same name beside them, and a transcript where there is one.

    ``tell(sentence)`` hears what is left out, here and in all readers. The speaker is ``speaker``, else the folder that a
    file lies in. One recording in ten, by its name, is for validation
    and one for testing, the same ones wherever the folder lies.
    """
    folder = top(folder)
    found, mute = [], []
    for motion in sorted(path for path in folder.rglob("*") if path.suffix.lower() in motion_files.SUFFIXES):
        sound = next((motion.with_suffix(suffix) for suffix in SOUNDS if motion.with_suffix(suffix).is_file()), None)
        if sound is None:
            mute.append(motion)
            continue
        name = motion.relative_to(folder).with_suffix("").as_posix()
        owner = speaker or (motion.parent.name if motion.parent != folder else folder.name)
        found.append(Found(name, motion, sound, transcripts.beside(motion), owner, tenth(name)))
    left_out([path.name for path in mute], "no sound file of the same name beside them", tell)
    return some(found, folder, "a .bvh or .npz with a sound file of the same name")


def zeroeggs(folder: str | PathLike, tell: Tell = silent) -> list[Found]:
    """ZeroEGGS: files such as ``010_Happy_1_x_1_0.bvh``; the style in the name is the speaker; one in ten each is held out."""
    folder, found, strange, mute = top(folder), [], [], []
    for motion in sorted(folder.rglob("*.bvh")):
        match = re.fullmatch(r"\d+_([A-Za-z_]+?)_\d+.*", motion.stem)
        sounds = [motion.with_suffix(".wav"), *(motion.parent.parent.rglob(f"{motion.stem}.wav"))]
        sound = next((path for path in sounds if path.is_file()), None)
        if match is None or sound is None:
            (strange if match is None else mute).append(motion)
            continue
        words = transcripts.beside(motion) or transcripts.beside(sound)
        found.append(Found(motion.stem, motion, sound, words, match[1].lower(), tenth(motion.stem)))
    left_out([path.name for path in strange], "no style in their names", tell)
    left_out([path.name for path in mute], "no .wav of the same name", tell)
    return some(found, folder, "files such as 010_Happy_1_x_1_0.bvh with a .wav of the same name")


def beat2(folder: str | PathLike, tell: Tell = silent) -> list[Found]:
    """BEAT2: ``smplxflame_30/*.npz``, ``wave16k``, ``textgrid`` and ``train_test_split.csv``; names are NUMBER_SPEAKER_..."""
    folder, found, strange, mute = top(folder), [], [], []
    listed = {}
    table = folder / "train_test_split.csv"
    if table.is_file():
        listed = _listed(table)
    kinds = {"train": "train", "val": "validation", "test": "test", "additional": "train"}
    for motion in sorted((folder / "smplxflame_30").glob("*.npz")):
        sound = folder / "wave16k" / f"{motion.stem}.wav"
        parts = motion.stem.split("_")
        if not sound.is_file() or len(parts) < 2:
            (mute if len(parts) >= 2 else strange).append(motion)
            continue
        words = transcripts.beside(motion, folder / "textgrid")
        split = kinds.get(listed.get(motion.stem, ""), "train") if listed else tenth(motion.stem)
        found.append(Found(motion.stem, motion, sound, words, parts[1], split))
    left_out([path.name for path in strange], "no speaker in their names", tell)
    left_out([path.name for path in mute], "no sound in wave16k", tell)
    return some(found, folder, "smplxflame_30/*.npz with wave16k/*.wav")


def _listed(table: Path) -> dict[str, str]:
    """Which part each recording of BEAT2 is of."""
    try:
        with open(table, "rb") as file:
            text = file.read(LARGEST_TABLE).decode("utf-8-sig")
        return {row.get("id") or "": row.get("type") or "" for row in csv.DictReader(io.StringIO(text, newline=""))}
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise CorpusUnreadable(f"{table} is no readable table: {error}.", "Download it again.") from error


def recordings(
    found: list[Found],
    paper_joints: bool = False,
    body: np.ndarray = smplx.OFFSETS,
    tell: Tell = lambda name: None,
    fps: float = FPS,
) -> Iterator[Recording]:
    """Read one performance after the other at ``fps`` frames a second.

    ``paper_joints``: see :func:`ten_joints.directions`; ``body``: SMPL-X rest offsets.
    """
    for one in found:
        tell(one.name)
        motion = motion_files.load(one.motion, paper_joints, body)
        performed = ten_joints.resample(motion.directions, motion.fps, fps)
        sound = audio.load(one.sound)
        words = transcripts.read(one.words, sound) if one.words is not None else []
        yield Recording(one.name, sound, words, performed, one.speaker, one.split)


READERS: dict[str, Callable[..., list[Found]]] = {
    "plain": plain, "trinity": trinity, "genea": genea, "zeroeggs": zeroeggs, "beat2": beat2,
}  # fmt: skip
