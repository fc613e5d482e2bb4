"""The voices to which performances for the judge of talk are made: those of :mod:`talk_split` that are there."""

import csv
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path

from ...errors import UsageError
from . import human_recordings, talk_split
from .talks import Talk, load_human_recording

TOGETHER = 20
"""Single sentences that make one talk of about a minute."""
EXAMPLE = Path(__file__).parents[3] / "examples" / "hello.flac"
"""The shipped recording."""


def load(material: Path, reported: bool = True) -> list[Talk]:
    """Load the voices that are ``reported``, or those that settings are chosen on, as talks of about a minute.

    Raises :class:`UsageError` where ``material`` has none.
    """
    if not reported:
        return human_recordings.load_recordings([EXAMPLE] * EXAMPLE.is_file(), material) + _sentences(material, False)
    acted = sorted((material / "thorsten_emotional").glob("*.wav"))
    voices = _sentences(material, True)
    if acted:
        joined = human_recordings.join_recordings([load_human_recording(path) for path in acted])
        voices.append(replace(joined, name="acted emotions", recording="acted emotions"))
    if not voices:
        raise UsageError(f"{material} holds no voices.", "Name the folder with kathleen/, or recordings with --human.")
    return voices


def _sentences(material: Path, reported: bool) -> list[Talk]:
    """Return read sentences with their texts, joined; of those that settings are chosen on as many as one talk has."""
    folder = material / "kathleen"
    table = folder / "sentences.csv"
    if not table.is_file():
        return []
    patterns = talk_split.VOICES_REPORTED if reported else talk_split.VOICES_CHOSEN_ON
    with table.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if any(fnmatch(row["file"], pattern) for pattern in patterns)]
    rows = rows if reported else rows[:TOGETHER]
    groups = [rows[begin : begin + TOGETHER] for begin in range(0, len(rows), TOGETHER)]
    talks = []
    for number, group in enumerate(groups):
        parts = [load_human_recording(folder / row["file"], row["text"]) for row in group]
        name = f"read sentences {number + 1}"
        talks.append(replace(human_recordings.join_recordings(parts), name=name, recording=name))
    return talks
