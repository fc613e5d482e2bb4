"""Readers for BEAT2, ZeroEGGS and plain folders of motion, sound and transcripts; and all readers by name."""

import csv
import io
import re
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from ...files import open_file
from ...motion.readers import motion_files, smplx
from ...motion.skeleton import FPS
from ...sound import audio
from . import transcripts
from .genea import genea, trinity
from .listing import LARGEST_TABLE, PerformanceFiles, Report, data_folder, ignore, report_skipped, require_some, split_of
from .recording import Recording
from .resampling import resample

SOUNDS = (".wav", ".flac", ".mp3", ".ogg", ".m4a")


def plain(folder: str | PathLike, speaker: str | None = None, tell: Report = ignore) -> list[PerformanceFiles]:
    """List motion files with a sound file of the same name, and a transcript if there is one.

    ``tell(sentence)`` is called with reports on skipped recordings, as in all readers. The speaker is ``speaker``, else the
    name of the file's folder. One recording in ten, by the name of its files alone, is for validation and one for the
    test: what several people perform, each in a folder of their own, is in one part.
    """
    folder = data_folder(folder)
    performances, without_sound = [], []
    for motion in sorted(path for path in folder.rglob("*") if path.suffix.lower() in motion_files.SUFFIXES):
        sound = next((motion.with_suffix(suffix) for suffix in SOUNDS if motion.with_suffix(suffix).is_file()), None)
        if sound is None:
            without_sound.append(motion)
            continue
        name = motion.relative_to(folder).with_suffix("").as_posix()
        owner = speaker or (motion.parent.name if motion.parent != folder else folder.name)
        words = transcripts.transcript_beside(motion)
        performances.append(PerformanceFiles(name, motion, sound, words, owner, split_of(motion.stem)))
    report_skipped([path.name for path in without_sound], "no sound file of the same name beside them", tell)
    return require_some(performances, folder, "a .bvh or .npz with a sound file of the same name")


def zeroeggs(folder: str | PathLike, tell: Report = ignore) -> list[PerformanceFiles]:
    """List the files of ZeroEGGS, such as ``010_Happy_1_x_1_0.bvh``, with the style as speaker, split like :func:`plain`."""
    folder = data_folder(folder)
    performances, unnamed, without_sound = [], [], []
    for motion in sorted(folder.rglob("*.bvh")):
        match = re.fullmatch(r"\d+_([A-Za-z_]+?)_\d+.*", motion.stem)
        sounds = [motion.with_suffix(".wav"), *(motion.parent.parent.rglob(f"{motion.stem}.wav"))]
        sound = next((path for path in sounds if path.is_file()), None)
        if match is None or sound is None:
            (unnamed if match is None else without_sound).append(motion)
            continue
        words = transcripts.transcript_beside(motion) or transcripts.transcript_beside(sound)
        performances.append(PerformanceFiles(motion.stem, motion, sound, words, match[1].lower(), split_of(motion.stem)))
    report_skipped([path.name for path in unnamed], "no style in their names", tell)
    report_skipped([path.name for path in without_sound], "no .wav of the same name", tell)
    return require_some(performances, folder, "files such as 010_Happy_1_x_1_0.bvh with a .wav of the same name")


def beat2(folder: str | PathLike, tell: Report = ignore) -> list[PerformanceFiles]:
    """List BEAT2's ``smplxflame_30/*.npz``, ``wave16k``, ``textgrid`` and ``train_test_split.csv``; by NUMBER_SPEAKER_..."""
    folder = data_folder(folder)
    performances, unnamed, without_sound = [], [], []
    table = folder / "train_test_split.csv"
    parts_by_name = _read_parts(table) if table.is_file() else {}
    kinds = {"train": "train", "val": "validation", "test": "test", "additional": "train"}
    for motion in sorted((folder / "smplxflame_30").glob("*.npz")):
        sound = folder / "wave16k" / f"{motion.stem}.wav"
        parts = motion.stem.split("_")
        if not sound.is_file() or len(parts) < 2:
            (without_sound if len(parts) >= 2 else unnamed).append(motion)
            continue
        words = transcripts.transcript_beside(motion, folder / "textgrid")
        split = kinds.get(parts_by_name.get(motion.stem, ""), "train") if parts_by_name else split_of(motion.stem)
        performances.append(PerformanceFiles(motion.stem, motion, sound, words, parts[1], split))
    report_skipped([path.name for path in unnamed], "no speaker in their names", tell)
    report_skipped([path.name for path in without_sound], "no sound in wave16k", tell)
    return require_some(performances, folder, "smplxflame_30/*.npz with wave16k/*.wav")


def _read_parts(table: Path) -> dict[str, str]:
    """Return the part of each recording of BEAT2, such as "train"."""
    try:
        with open_file(table) as file:
            text = file.read(LARGEST_TABLE).decode("utf-8-sig")
        return {row.get("id") or "": row.get("type") or "" for row in csv.DictReader(io.StringIO(text, newline=""))}
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise CorpusUnreadable(f"{table} is no readable table: {error}.", "Download it again.") from error


def recordings(
    performances: list[PerformanceFiles],
    paper_joints: bool = False,
    body: np.ndarray = smplx.OFFSETS,
    tell: Report = lambda name: None,
    fps: float = FPS,
) -> Iterator[Recording]:
    """Read one performance after the other at ``fps`` frames per second; ``tell`` is called with the name of each.

    ``paper_joints`` is that of :func:`ten_joints.directions`, ``body`` are SMPL-X rest offsets.
    """
    for one in performances:
        tell(one.name)
        motion = motion_files.load(one.motion, paper_joints, body)
        directions = resample(motion.directions, motion.fps, fps)
        sound = audio.load(one.sound)
        words = transcripts.read(one.words, sound) if one.words is not None else []
        yield Recording(one.name, sound, words, directions, one.speaker, one.split)


READERS: dict[str, Callable[..., list[PerformanceFiles]]] = {
    "plain": plain, "trinity": trinity, "genea": genea, "zeroeggs": zeroeggs, "beat2": beat2,
}  # fmt: skip
