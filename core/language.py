"""An aligner model of the user's own, for another language: a folder with what pocketsphinx needs."""

import json
from os import PathLike
from pathlib import Path

from .errors import TranscriptUnreadable

_REMEDY = "See docs/transcripts.md, Other languages."


def load(folder: str | PathLike | None) -> dict | None:
    """What the aligner is told of a folder (None: English): paths ``acoustic``, ``dictionary``, and ``letters``, each or None.

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
    if acoustic is not None and letters is None:
        letters = {}  # guesses by English rules would name phones that this model lacks
    return {
        "acoustic": None if acoustic is None else str(acoustic),
        "dictionary": str(dictionaries[0]) if dictionaries else None,
        "letters": letters,
    }


def fingerprint(model: dict | None) -> list:
    """What distinguishes a model in JSON: paths, sizes and times of its files, and its letters."""
    if model is None:
        return []
    files = [Path(model["dictionary"])] if model["dictionary"] else []
    if model["acoustic"]:
        files += sorted(path for path in Path(model["acoustic"]).iterdir() if path.is_file())
    states = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in files]
    return [states, model["letters"]]


def _letters(path: Path) -> dict[str, str]:
    try:
        letters = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise TranscriptUnreadable(f"{path} is not valid JSON.", _REMEDY) from error
    if not isinstance(letters, dict) or not all(isinstance(value, str) and key for key, value in letters.items()):
        raise TranscriptUnreadable(f"{path} does not map letters to phones.", 'Write {"sch": "SH", "a": "AA", ...}.')
    return {key.lower(): value for key, value in letters.items()}
