"""Loads another language for the aligner: by its code, with pronunciations from eSpeak NG, or from a folder of models."""

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from .. import json_text
from ..errors import EngineMissing, TranscriptUnreadable
from ..optional_packages import has_espeak, pocketsphinx
from .aligner import sphinx_model

_REMEDY = "See docs/transcripts.md, Other languages."
_MAX_DICTIONARY_BYTES, _MAX_LETTERS_BYTES, _MAX_RULE_LENGTH = 256_000_000, 1_000_000, 100
"""The last limits the characters of the phones of one letter rule."""


def load_language(folder: str | PathLike | None = None, code: str | None = None) -> dict | None:
    """Return the aligner's model of a language (None: English) as a dictionary that is sent to its process as JSON.

    Keys, each of which may be None: ``voice`` of eSpeak NG, the paths ``acoustic`` and ``dictionary`` in the folder, and
    ``letters`` (see :func:`_folder`). With a ``code`` (``de``, ``fr``, ``pt-br``) words that are not in the folder's dictionary
    are pronounced by eSpeak NG in the phones of the English acoustic model. Raises :class:`EngineMissing` if an extra is
    missing, and :class:`TranscriptUnreadable`."""
    model, voice = _folder(folder), _voice(code)
    if voice is None:
        return model
    if model is not None and model["acoustic"] is not None:
        message = f"The aligner model {folder} has sounds of its own, which eSpeak NG does not know."
        raise TranscriptUnreadable(message, "Leave out the language or the acoustic model.")
    return {**(model or {"acoustic": None, "dictionary": None}), "letters": {}, "voice": voice}


def is_foreign(model: dict | None) -> bool:
    """Return whether numbers and signs are read in another language than English."""
    return model is not None and model["voice"] is not None


def _voice(code: str | None) -> str | None:
    """Return eSpeak NG's voice for a language code, a file name; None for English, which has a dictionary.

    Raises :class:`EngineMissing` and, for an unknown code, :class:`TranscriptUnreadable`."""
    code = (code or "en").strip().lower().replace("_", "-")
    if code == "en" or code.startswith("en-"):
        return None
    if not has_espeak():
        message = "The pronunciation of other languages is not installed."
        raise EngineMissing(message, 'Add it with: pip install "s2ag[languages]"')
    from .aligner.espeak import find_voice

    return find_voice(code)


def _folder(folder: str | PathLike | None) -> dict[str, Any] | None:
    """Find ``acoustic``, ``dictionary`` and ``letters`` in a folder.

    The acoustic model is the folder itself or a folder inside it that contains a file ``mdef``; the dictionary is the only
    ``.dict`` or ``.dic`` file; ``letters.json`` maps letters to phones for words that are in no dictionary. Without an acoustic
    model the English one is used with its phones, which suits accents and invented words but not another language. Raises
    :class:`TranscriptUnreadable`."""
    if folder is None:
        return None
    folder = Path(folder)
    if not folder.is_dir():
        raise TranscriptUnreadable(f"The aligner model {folder} is not a folder.", _REMEDY)
    acoustic = next((path.parent for path in [folder / "mdef", *sorted(folder.glob("*/mdef"))] if path.is_file()), None)
    dictionaries = sorted(path for path in folder.iterdir() if path.suffix in (".dict", ".dic") and path.is_file())
    letters = _letters(folder / "letters.json") if (folder / "letters.json").is_file() else None
    if len(dictionaries) > 1:
        raise TranscriptUnreadable(f"The aligner model {folder} holds {len(dictionaries)} dictionaries.", "Leave one there.")
    if not dictionaries and letters is None:
        raise TranscriptUnreadable(f"The aligner model {folder} holds neither a dictionary nor letters.json.", _REMEDY)
    if any(path.stat().st_size > _MAX_DICTIONARY_BYTES for path in dictionaries):
        most = _MAX_DICTIONARY_BYTES // 1_000_000
        raise TranscriptUnreadable(f"{dictionaries[0]} is larger than {most} MB.", "Leave out rare words.")
    if acoustic is not None:
        _check(acoustic)
    if acoustic is not None and letters is None:
        letters = {}  # English letter rules would give phones that this model lacks
    return {
        "acoustic": None if acoustic is None else str(acoustic),
        "dictionary": str(dictionaries[0]) if dictionaries else None,
        "letters": letters,
        "voice": None,
    }


def _check(acoustic: Path) -> None:
    """Raise :class:`EngineMissing` if the acoustic model can only be read by pocketsphinx, which is not installed."""
    if not pocketsphinx():
        try:
            sphinx_model.read(acoustic)
        except sphinx_model.UnreadableModel as error:
            message = f"The acoustic model {acoustic} is of a kind that needs the Python package pocketsphinx."
            raise EngineMissing(message, 'Install it with: pip install "s2ag[full]"') from error


def fingerprint(model: Mapping[str, Any] | None) -> list:
    """Return JSON that identifies a model in cache keys: paths, sizes and times of its files, letter rules and language."""
    if model is None:
        return []
    files = [Path(model["dictionary"])] if model["dictionary"] else []
    if model["acoustic"]:
        files += sorted(path for path in Path(model["acoustic"]).iterdir() if path.is_file())
    states = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in files]
    return [states, model["letters"], model["voice"]]


def _letters(path: Path) -> dict[str, str]:
    """Read the letter rules; raise :class:`TranscriptUnreadable` if they do not map letters to phones."""
    try:
        letters = json_text.read(path, _MAX_LETTERS_BYTES)
    except (OSError, json_text.NotJson) as error:
        raise TranscriptUnreadable(f"{path} is not valid JSON.", _REMEDY) from error
    right = isinstance(letters, dict) and "" not in letters and all(isinstance(phones, str) for phones in letters.values())
    if not right or max(map(len, letters.values()), default=0) > _MAX_RULE_LENGTH:
        raise TranscriptUnreadable(f"{path} does not map letters to phones.", 'Write {"sch": "SH", "a": "AA", ...}.')
    return {key.lower(): value for key, value in letters.items()}
