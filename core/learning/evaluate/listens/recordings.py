"""Recordings to listen to: plain ones without words, and acted ones whose names tell the emotion."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ....errors import UsageError
from ....sound import audio, voice_activity
from ..comparisons import evenly_spaced
from ..talks import Talk

EMOTIONS = {
    "anger": ("anger", "angry"),
    "joy": ("joy", "joyful", "happiness", "happy", "amused"),
    "fear": ("fear", "fearful", "afraid"),
    "surprise": ("surprise", "surprised"),
    "sadness": ("sadness", "sad"),
    "boredom": ("boredom", "bored"),
    "tiredness": ("tiredness", "tired", "sleepy"),
    "neutral": ("neutral",),
}
"""Emotions that are told apart, and the words for each in the names of files and folders."""
HIGH, LOW = ("anger", "joy", "fear", "surprise"), ("sadness", "boredom", "tiredness")
"""Emotions of high and of low arousal."""
LABELS = "emotions.csv"
"""A file with the columns ``file`` and ``emotion`` in a folder of acted speech; without it, names tell."""

LONGEST = 900.0
"""Seconds of a reading that are used, enough for forty-five excerpts of a judge."""
SOUNDS = (".wav", ".flac", ".opus", ".ogg", ".mp3")
_EMODB = re.compile(r"\d\d[ab]\d\d([WLAFTN])[a-z]?")
_LETTERS = {"W": "anger", "L": "boredom", "A": "fear", "F": "joy", "T": "sadness", "N": "neutral"}
"""Names of the Berlin Database of Emotional Speech, whose letters stand for German words."""
_RAVDESS = re.compile(r"0[13]-0\d-(0\d)-0\d-0\d-0\d-\d\d")
_NUMBERS = {"01": "neutral", "03": "joy", "04": "sadness", "05": "anger", "06": "fear", "08": "surprise"}
"""Names of the Ryerson database, whose third number tells the emotion."""
_PAUSE, _MIN_LINE = 0.5, 2.0
"""Seconds between a reading and what is said after it, and the length of the shortest line."""


@dataclass(frozen=True)
class Acted:
    """Acted speech: the recording, and one of :data:`EMOTIONS`."""

    talk: Talk
    emotion: str


def plain(name: str, sound: np.ndarray) -> Talk:
    """Return a recording ``(n,)`` at 16 kHz of which nothing but the sound is known."""
    return Talk(name, name, np.asarray(sound, np.float32), (), np.zeros((0, 3)))


def load(path: str | PathLike, seconds: float | None = None) -> Talk:
    """Load a recording without words, or its first ``seconds``. Raises :class:`S2agError` for unreadable files."""
    sound = audio.load(path)
    return plain(Path(path).stem, sound if seconds is None else sound[: int(seconds * audio.SAMPLE_RATE)])


def load_reading(path: str | PathLike) -> Talk:
    """Load a reading: a recording, or the recordings of a folder one after another, at most :data:`LONGEST` seconds of them.

    Raises :class:`UsageError` for a folder without recordings.
    """
    path, seconds, pieces = Path(path), 0.0, []
    if not path.is_dir():
        return load(path)
    for file in sorted(one for one in path.iterdir() if one.suffix.lower() in SOUNDS):
        pieces += [audio.load(file), np.zeros(round(_PAUSE * audio.SAMPLE_RATE), np.float32)]
        seconds += (len(pieces[-2]) + len(pieces[-1])) / audio.SAMPLE_RATE
        if seconds >= LONGEST:
            break
    if not pieces:
        raise UsageError(f"{path} holds no recordings.", "Name a recording or a folder of recordings.")
    return plain(path.name, np.concatenate(pieces[:-1]))


def load_acted(folder: str | PathLike) -> list[Acted]:
    """Load all acted recordings under a folder whose emotion is known and one of :data:`EMOTIONS`.

    Raises :class:`UsageError` where there is none.
    """
    folder, result = Path(folder), []
    labels = _labels(folder)
    for path in sorted(one for one in folder.rglob("*") if one.suffix.lower() in SOUNDS):
        emotion = emotion_of(labels.get(path.name, "")) if labels else emotion_of(path.stem) or emotion_of(path.parent.name)
        if emotion:
            name = "-".join(path.relative_to(folder).with_suffix("").parts)
            result.append(Acted(plain(name, audio.load(path)), emotion))
    if not result:
        message = f"{folder} holds no acted speech whose emotion is known."
        raise UsageError(message, f"Have the names tell it, as in angry-1.wav, or a table {LABELS} (file, emotion).")
    return result


def emotion_of(name: str) -> str:
    """Return the emotion that a name tells, "" for none: by its words, or by the codes of two well-known databases."""
    words = re.findall(r"[a-z]+", name.lower())
    found = next((emotion for emotion, known in EMOTIONS.items() if set(known) & set(words)), "")
    if found:
        return found
    for pattern, codes in ((_EMODB, _LETTERS), (_RAVDESS, _NUMBERS)):
        match = pattern.fullmatch(name)
        if match:
            return codes.get(match[1], "")
    return ""


def preceded(talk: Talk, reading: np.ndarray) -> tuple[Talk, float]:
    """Put a reading ``(n,)``, made equally loud, and a pause before a recording; also return the second at which it begins."""
    loud = [np.sqrt(np.mean(np.square(sound, dtype=float))) for sound in (talk.audio, reading)]
    before = np.asarray(reading, float) * loud[0] / max(loud[1], 1e-9)
    before = np.concatenate([before / max(np.abs(before).max(initial=0), 1.0), np.zeros(round(_PAUSE * audio.SAMPLE_RATE))])
    return plain(f"{talk.name} after", np.concatenate([before, talk.audio])), len(before) / audio.SAMPLE_RATE


def cut_excerpts(talks: Sequence[Talk], seconds: float, most: int) -> list[Talk]:
    """Cut recordings into whole excerpts of so many seconds, with their words; at most so many, evenly spread."""
    result = []
    for talk in talks:
        for number in range(int(len(talk.audio) / audio.SAMPLE_RATE / seconds)):
            start, end = number * seconds, (number + 1) * seconds
            span = slice(int(start * audio.SAMPLE_RATE), int(end * audio.SAMPLE_RATE))
            words = tuple((word, a - start, b - start) for word, a, b in talk.words if a >= start and b <= end)
            result.append(replace(plain(f"{talk.name} {start:g} to {end:g}", talk.audio[span]), words=words))
    return evenly_spaced(result, most)


def lines(talks: Sequence[Talk], most: int) -> list[Talk]:
    """Cut lines of two seconds and more at the pauses of recordings; at most so many, evenly spread."""
    result = []
    for talk in talks:
        for start, end in voice_activity.segments(talk.audio):
            if end - start >= _MIN_LINE:
                span = slice(int(start * audio.SAMPLE_RATE), int(end * audio.SAMPLE_RATE))
                result.append(plain(f"{talk.name} {start:.1f} to {end:.1f}", talk.audio[span]))
    return evenly_spaced(result, most)


def _labels(folder: Path) -> dict[str, str]:
    """Return the emotions of files by name as a table tells them; empty without one."""
    path = folder / LABELS
    if not path.is_file():
        return {}
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    if not all(row.get("file") and row.get("emotion") for row in rows):
        raise UsageError(f"{path} has no columns file and emotion.", "Write both names in its first line.")
    return {Path(row["file"]).name: row["emotion"] for row in rows}
