"""Readers for the data of the GENEA Challenges: 2020 (Trinity), 2022 and 2023 (Talking With Hands)."""

import csv
import io
from os import PathLike
from pathlib import Path

from ...errors import CorpusUnreadable
from ...files import open_file
from . import transcripts
from .listing import LARGEST_TABLE, PerformanceFiles, Report, data_folder, ignore, report_skipped, require_some

PARTS = {"trn": "train", "val": "validation", "tst": "test"}
MAIN, OTHER = "main-agent", "interloctr"
UNKNOWN = "unknown"


def trinity(folder: str | PathLike, tell: Report = ignore) -> list[PerformanceFiles]:
    """List the performances of GENEA 2020: ``Training_data`` and ``Test_data`` with Motion, Audio, Transcripts (reference D.3).

    Recording_001 is for validation, as in Gesticulator; all other training recordings for training. Nothing is skipped:
    a missing sound raises :class:`CorpusUnreadable`.
    """
    folder, performances = data_folder(folder), []
    for part, split in (("Training_data", "train"), ("Test_data", "test")):
        place = folder / part
        for motion in sorted((place / "Motion").glob("*.bvh")):
            sound = place / "Audio" / f"{motion.stem}.wav"
            if not sound.is_file():
                raise CorpusUnreadable(f"{sound} is missing.", "Download the release again.")
            words = transcripts.transcript_beside(motion, place / "Transcripts")
            own_split = "validation" if split == "train" and motion.stem == "Recording_001" else split
            performances.append(PerformanceFiles(motion.stem, motion, sound, words, "trinity", own_split))
    return require_some(performances, folder, "Training_data/Motion/*.bvh")


def genea(folder: str | PathLike, tell: Report = ignore) -> list[PerformanceFiles]:
    """List the performances of GENEA 2022 and 2023: ``trn``, ``val``, ``tst`` with ``bvh``, ``wav``, ``tsv``, speaker table.

    Of 2023's two people the main agent is read; in ``trn`` the interlocutor is the main agent of another recording.
    Recordings without motion (the challenges' own ``tst``) or sound are skipped and reported. Speakers are the table's
    numbers.
    """
    folder, performances = data_folder(folder), []
    without_sound: list[str] = []
    without_motion: list[str] = []
    without_speaker: list[str] = []
    interlocutors = 0
    for part, split in PARTS.items():
        place = _part(folder, part)
        people = _people(place)
        inner = place / MAIN if (place / MAIN).is_dir() else place
        interlocutors += len(list((place / OTHER / "bvh").glob("*.bvh")))
        names = {path.stem for kind in ("bvh", "wav") for path in (inner / kind).glob(f"*.{kind}")}
        for name in sorted(names):
            motion, sound, words = (inner / kind / f"{name}.{kind}" for kind in ("bvh", "wav", "tsv"))
            if not (motion.is_file() and sound.is_file()):
                (without_motion if sound.is_file() else without_sound).append(name)
                continue
            speaker = people.get(name.removesuffix(f"_{MAIN}"), UNKNOWN)
            if speaker == UNKNOWN:
                without_speaker.append(name)
            performances.append(PerformanceFiles(name, motion, sound, words if words.is_file() else None, speaker, split))
    report_skipped(without_sound, "no sound in wav", tell)
    report_skipped(without_motion, "no motion in bvh", tell)
    if interlocutors:
        tell(f"Interlocutors are left out ({interlocutors}): the main agents are read.")
    if without_speaker:
        count, first = len(without_speaker), without_speaker[0]
        tell(f"Recordings without a line in metadata.csv have one speaker, {UNKNOWN} ({count}): {first}, ...")
    return require_some(performances, folder, "trn/bvh/*.bvh (2022) or trn/main-agent/bvh/*.bvh (2023)")


def _part(folder: Path, part: str) -> Path:
    """Return the folder of a part: some people unpack ``trn.zip`` into a folder of its own."""
    return folder / part / part if (folder / part / part).is_dir() else folder / part


def _people(place: Path) -> dict[str, str]:
    """Return speakers by recording, from rows of name, fingers, number (2022) or name, number, fingers, ... (2023)."""
    tables = sorted(place.glob("*metadata.csv"))
    if not tables:
        return {}
    try:
        with open_file(tables[0]) as file:
            text = file.read(LARGEST_TABLE).decode("utf-8-sig")
        rows = [row for row in csv.reader(io.StringIO(text, newline="")) if len(row) >= 3]
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise CorpusUnreadable(f"{tables[0]} is no readable table: {error}.", "Download it again.") from error
    numbers = ((row[0].strip(), next((cell.strip() for cell in row[1:3] if cell.strip().isdecimal()), "")) for row in rows)
    return {name: number.lstrip("0") or "0" for name, number in numbers if number}
