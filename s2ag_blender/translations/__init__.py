"""The extension's words in other languages, given to Blender, which picks by the language of the preferences."""

import functools
import json
import re
from pathlib import Path

import bpy

from ...core.errors import S2agError

_NAME = "s2ag"
CONTEXT = "S2AG"
"""The context of all our words: without one Blender's own catalogue is asked first, in which some mean something else."""
_FOLDER = Path(__file__).parent
_MOST = 1000


def _tables(folder: Path) -> dict[str, dict[str, str]]:
    return {path.stem: json.loads(path.read_text("utf-8")) for path in folder.glob("*.json")}


LANGUAGES = _tables(_FOLDER)
"""Locale -> table of a whole language: ``{message: translation}``, a JSON file each."""
STYLES = _tables(_FOLDER / "styles")
"""The same for the names of the shipped styles."""


@functools.cache
def errors(locale: str) -> dict[str, str]:
    """What the engine and everything else says when it fails, ``{}`` for each name or number in it; empty for no table."""
    return _tables(_FOLDER / "errors").get(locale, {})


@functools.lru_cache(maxsize=_MOST)
def sentence(locale: str, text: str) -> str:
    """A finished sentence of :func:`errors` in another language, or ``text`` where it is none of them."""
    best, filled = -1, text
    for template, translated in errors(locale).items():
        fixed = template.split("{}")
        if len("".join(fixed)) > best and (found := re.fullmatch("(.*)".join(map(re.escape, fixed)), text, re.DOTALL)):
            best, filled = len("".join(fixed)), translated.format(*found.groups())
    return filled


def told(text: str, **values) -> str:
    """A sentence for the user in the user's language; ``values`` fill its ``{names}``."""
    translated = bpy.app.translations.pgettext_rpt(text, CONTEXT)
    if values:
        return translated.format(**values)
    locale = bpy.app.translations.locale
    return sentence(locale, text) if translated == text and locale in LANGUAGES else translated


def named(style: str) -> str:
    """A style's name in the user's language, where new data is named in it."""
    shown = style.capitalize()
    translated = bpy.app.translations.pgettext_data(shown, CONTEXT)
    return style if translated == shown else translated


def told_error(error: S2agError) -> str:
    """An error and its remedy in one line, in the user's language, for people who have a panel and no command line."""
    if "s2ag rig" in error.remedy:
        return f"{told(error.message)} {told('Choose its bones in the panel Bone Map.')}"
    return f"{told(error.message)} {told(error.remedy)}".strip()


def in_context(cls: type) -> None:
    """Let Blender look up what a class of ours is called, and its properties and their choices, among our words."""
    if issubclass(cls, (bpy.types.Panel, bpy.types.Operator, bpy.types.Menu)):
        cls.bl_translation_context = CONTEXT
    for base in cls.__mro__:
        if base.__module__.startswith(__package__.rpartition(".")[0]):
            for declared in getattr(base, "__annotations__", {}).values():
                declared.keywords.setdefault("translation_context", CONTEXT)


def register() -> None:
    """Give every table to Blender, under our own context and, for plain labels, under Blender's."""
    tables = {}
    for locale, table in LANGUAGES.items():
        words = {**table, **STYLES.get(locale, {})}
        pairs = {(context, message): text for message, text in words.items() for context in ("*", "Operator", CONTEXT)}
        tables[locale] = pairs
    bpy.app.translations.register(_NAME, tables)


def unregister() -> None:
    """Take the tables back."""
    bpy.app.translations.unregister(_NAME)
