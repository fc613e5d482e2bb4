"""Another language for the aligner: its code, so that eSpeak NG pronounces words, or a folder with what pocketsphinx needs."""

import importlib.util
import re
from os import PathLike
from pathlib import Path

from .. import json_text
from ..errors import EngineMissing, TranscriptUnreadable
from .aligner import sphinx_model

_REMEDY = "See docs/transcripts.md, Other languages."
_PACKAGE = "espeakng_loader"
_LARGEST, _LETTERS, _PHONES = 256_000_000, 1_000_000, 100
"""Bytes of a dictionary and of letters.json, and signs that phones of a letter may take."""
_CODE = re.compile(r"^language[ \t]+([\w-]+)", re.MULTILINE)


def load(folder: str | PathLike | None = None, code: str | None = None) -> dict | None:
    """What the aligner is told of a language (None: English): ``voice``, a code for eSpeak NG, and of the folder the paths
    ``acoustic`` and ``dictionary``, and ``letters``; each may be None.

    With a ``code`` (``de``, ``fr``, ``pt-br``) words that are not in the folder's dictionary are pronounced by eSpeak NG in the
    phones of the English acoustic model. Raises :class:`EngineMissing` where that needs an extra, and
    :class:`TranscriptUnreadable`.
    """
    model, voice = _folder(folder), _voice(code)
    if voice is None:
        return model
    if model is not None and model["acoustic"] is not None:
        message = f"The aligner model {folder} has sounds of its own, which eSpeak NG does not know."
        raise TranscriptUnreadable(message, "Leave out the language or the acoustic model.")
    return {**(model or {"acoustic": None, "dictionary": None}), "letters": {}, "voice": voice}


def foreign(model: dict | None) -> bool:
    """Whether numbers and signs are read as another language does."""
    return model is not None and model["voice"] is not None


def _voice(code: str | None) -> str | None:
    """eSpeak NG's voice for a code, which is the name of a file; None for English, which has a dictionary."""
    code = (code or "en").strip().lower().replace("_", "-")
    if code == "en" or code.startswith("en-"):
        return None
    spec = importlib.util.find_spec(_PACKAGE)
    if spec is None:
        message = "The pronunciation of other languages is not installed."
        raise EngineMissing(message, 'Add it with: pip install "s2ag[languages]"')
    voices: dict[str, str] = {}
    for path in sorted(Path(spec.origin).with_name("espeak-ng-data").joinpath("lang").rglob("*")):
        if path.is_file():
            text = path.read_text(encoding="utf-8", errors="replace")
            voices |= {found.lower(): path.name for found in _CODE.findall(text) if found.lower() not in voices}
            voices[path.name.lower()] = path.name
    if code not in voices:
        known = ", ".join(sorted(found for found in voices if len(found) == 2))
        raise TranscriptUnreadable(f"eSpeak NG does not know the language {code}.", f"It knows {known} and others.")
    return voices[code]


def _folder(folder: str | PathLike | None) -> dict | None:
    """The folder's ``acoustic``, ``dictionary`` and ``letters``.

    The acoustic model is the folder itself or one inside it that holds a file ``mdef``; the dictionary is its only ``.dict`` or
    ``.dic``; ``letters.json`` maps spelling to phones for words that are in no dictionary. Without an acoustic model the
    English one is used, and phones are its own: that serves accents and invented words, not another language. Raises
    :class:`TranscriptUnreadable`.
    """
    if folder is None:
        return None
    folder = Path(folder)
    if not folder.is_dir():
        raise TranscriptUnreadable(f"The aligner model {folder} is not a folder.", _REMEDY)
    acoustic = next((path.parent for path in [folder / "mdef", *sorted(folder.glob("*/mdef"))] if path.is_file()), None)
    dictionaries = sorted(path for path in folder.iterdir() if path.suffix in (".dict", ".dic"))
    letters = _letters(folder / "letters.json") if (folder / "letters.json").is_file() else None
    if len(dictionaries) > 1:
        raise TranscriptUnreadable(f"The aligner model {folder} holds {len(dictionaries)} dictionaries.", "Leave one there.")
    if not dictionaries and letters is None:
        raise TranscriptUnreadable(f"The aligner model {folder} holds neither a dictionary nor letters.json.", _REMEDY)
    if any(path.stat().st_size > _LARGEST for path in dictionaries):
        raise TranscriptUnreadable(f"{dictionaries[0]} is larger than {_LARGEST // 1_000_000} MB.", "Leave out rare words.")
    if acoustic is not None:
        _check(acoustic)
    if acoustic is not None and letters is None:
        letters = {}  # guesses by English rules would name phones that this model lacks
    return {
        "acoustic": None if acoustic is None else str(acoustic),
        "dictionary": str(dictionaries[0]) if dictionaries else None,
        "letters": letters,
        "voice": None,
    }


def _check(acoustic: Path) -> None:
    """Raise :class:`EngineMissing` for sounds that only pocketsphinx can read, where it is not installed."""
    if importlib.util.find_spec("pocketsphinx") is None:
        try:
            sphinx_model.read(acoustic)
        except sphinx_model.UnreadableModel as error:
            message = f"The acoustic model {acoustic} is of a kind that needs the Python package pocketsphinx."
            raise EngineMissing(message, 'Install it with: pip install "s2ag[full]"') from error


def fingerprint(model: dict | None) -> list:
    """What distinguishes a model in JSON: paths, sizes and times of its files, its letters and its language."""
    if model is None:
        return []
    files = [Path(model["dictionary"])] if model["dictionary"] else []
    if model["acoustic"]:
        files += sorted(path for path in Path(model["acoustic"]).iterdir() if path.is_file())
    states = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in files]
    return [states, model["letters"], model["voice"]]


def _letters(path: Path) -> dict[str, str]:
    try:
        letters = json_text.read(path, _LETTERS)
    except (OSError, json_text.NotJson) as error:
        raise TranscriptUnreadable(f"{path} is not valid JSON.", _REMEDY) from error
    if not isinstance(letters, dict) or not all(map(_is_rule, letters, letters.values())):
        raise TranscriptUnreadable(f"{path} does not map letters to phones.", 'Write {"sch": "SH", "a": "AA", ...}.')
    return {key.lower(): value for key, value in letters.items()}


def _is_rule(letters: str, phones: object) -> bool:
    return bool(letters) and isinstance(phones, str) and len(phones) <= _PHONES
