"""Recordings of people's voices on which performances are judged, and captured motion to compare with."""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import groupby
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import UsageError
from ...motion import skeleton
from ...sound.audio import SAMPLE_RATE
from .talks import Talk, load_human_recording

if TYPE_CHECKING:
    from ..corpus.library import Gesture

SHORT = 12.0
"""Seconds: shorter recordings of a folder are joined, because one alone is too short to measure."""
PAUSE = 0.6
"""Seconds between two joined recordings."""
LIBRIVOX = Path("/usr/share/pocketsphinx/test/data/librivox")
"""Folder of Debian's pocketsphinx-testdata."""
MINUTE = 60.0
_NUMERALS = {"I": "one", "II": "two"}
TRAINED_ON = " (trained on)"
"""Suffix of the name of a recording that is also in corpora."""


def load_recordings(paths: Sequence[str | PathLike], material: str | PathLike | None = None) -> list[Talk]:
    """Load the named recordings, and with ``material`` also the LibriVox clips and its sonnets, as far as they exist.

    A text file of a recording's name is its transcript. Raises :class:`S2agError` for unreadable files.
    """
    talks = [(Path(path).parent, load_human_recording(path)) for path in paths]
    if material is not None:
        talks += [(LIBRIVOX, replace(load_human_recording(path, text), name="LibriVox")) for path, text in _librivox()]
        talks += [(path, replace(load_human_recording(path, text), name=name)) for path, text, name in _sonnets(Path(material))]
    groups = groupby(talks, lambda one: (one[0], None) if _seconds(one[1]) < SHORT else (one[0], id(one[1])))
    return _unique_names([join_recordings([talk for _, talk in group]) for _, group in groups])


def join_recordings(talks: Sequence[Talk]) -> Talk:
    """Join several recordings to one with pauses between; a single one is returned as it is."""
    if len(talks) == 1:
        return talks[0]
    pieces, words, accents, at = [], [], [], 0.0
    for talk in talks:
        pieces += [talk.audio, np.zeros(round(PAUSE * SAMPLE_RATE), np.float32)]
        words += [(text, start + at, end + at) for text, start, end in talk.words]
        accents.append(talk.accents + [at, 0, 0])
        at += _seconds(talk) + PAUSE
    name = f"{re.sub(r'[-_ .]?[0-9]+$', '', talks[0].name) or talks[0].name}, {len(talks)} joined"
    audio = np.concatenate(pieces[:-1])
    return Talk(name, name, audio, tuple(words), np.concatenate(accents))


def captured_motion(material: str | PathLike) -> dict[str, np.ndarray]:
    """Return captured motion ``(frames, 9, 3)`` by name: a minute of clips one after another, and a conversation.

    Raises :class:`UsageError` where ``material`` holds no clips.
    """
    from ..corpus import unity

    gestures = load_gestures(material)
    length, minute, picked = 0, round(MINUTE * skeleton.FPS), []
    for row in np.random.default_rng(0).permutation(len(gestures)):
        clip = gestures[row].clip
        picked.append(clip.at(np.arange(clip.onset, clip.rest, 1 / skeleton.FPS)))
        length += len(picked[-1])
        if length >= minute:
            break
    result = {"clips": skeleton.normalize(np.concatenate(picked)[:minute])}
    path = Path(material) / unity.CONVERSATION
    if path.is_file():
        animation = unity.load(path)
        motion = unity.to_directions(animation, *unity.STRETCH)
        rows = np.arange(0, len(motion) - 1, animation.fps / skeleton.FPS).round().astype(int)
        result["conversation"] = skeleton.normalize(motion[rows])
    return result


@lru_cache(maxsize=1)
def load_gestures(material: str | PathLike) -> "list[Gesture]":
    """Load the library of captured and authored gestures. Raises :class:`UsageError` where ``material`` has none."""
    from ..corpus import library

    try:
        return library.load(material)
    except FileNotFoundError as error:
        message = f"{material} holds no smartbody gestures."
        raise UsageError(message, "Name the folder with the public material, or leave --material out.") from error


def _librivox() -> list[tuple[Path, str]]:
    """Return the clips of the package with their texts; empty where it is not installed."""
    transcription = LIBRIVOX / "transcription"
    if not transcription.is_file():
        return []
    entries = re.findall(r"<s>(.*?)</s>\s*\((\S+?)\)", transcription.read_text("utf-8"))
    clips = [(LIBRIVOX / f"{name}.wav", text.strip()) for text, name in entries]
    return [(path, text) for path, text in clips if path.is_file()]


def _sonnets(material: Path) -> list[tuple[Path, str, str]]:
    """Return files, texts and names of sonnets. The first one is also in the training data."""
    sonnets = []
    for page in sorted((material / "speech").glob("p*.xhtml")):
        path = page.with_suffix(".mp3")
        if path.is_file():
            lines: list[str] = re.findall(r'<span id="f\d+">(.*?)</span>', page.read_text("utf-8"))
            text = "\n".join(_NUMERALS.get(line, line) for line in lines)
            sonnets.append((path, text, f"sonnet {len(sonnets) + 1}{TRAINED_ON if not sonnets else ''}"))
    return sonnets


def _seconds(talk: Talk) -> float:
    return len(talk.audio) / SAMPLE_RATE


def _unique_names(talks: list[Talk]) -> list[Talk]:
    """Number the talks' names unless they all differ."""
    names = [talk.name for talk in talks]
    unique = len(set(names)) == len(names)
    return talks if unique else [replace(talk, name=f"{talk.name} {row + 1}") for row, talk in enumerate(talks)]
