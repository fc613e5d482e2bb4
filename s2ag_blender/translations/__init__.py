"""The extension's words in other languages, given to Blender, which picks by the language of the preferences."""

import json
from pathlib import Path

import bpy

from ...core.errors import S2agError

_NAME = "s2ag"
LANGUAGES = {path.stem: json.loads(path.read_text("utf-8")) for path in Path(__file__).parent.glob("*.json")}
"""Locale -> table of a whole language: ``{message: translation}``, a JSON file each."""


def told(text: str, **values) -> str:
    """A sentence for the user in the user's language; ``values`` fill its ``{names}``."""
    text = bpy.app.translations.pgettext_rpt(text)
    return text.format(**values) if values else text


def told_error(error: S2agError) -> str:
    """An error and its remedy in one line, in the user's language."""
    return f"{told(error.message)} {told(error.remedy)}".strip()


def register() -> None:
    """Give every table to Blender."""
    tables = {}
    for locale, table in LANGUAGES.items():
        # Names of operators have a context of their own in Blender.
        pairs = {(context, message): text for message, text in table.items() for context in ("*", "Operator")}
        tables[locale] = pairs
    bpy.app.translations.register(_NAME, tables)


def unregister() -> None:
    """Take the tables back."""
    bpy.app.translations.unregister(_NAME)
