"""Translations of the extension's texts, registered with Blender, which picks the language of its preferences."""

import functools
import json
import re
from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import S2agError

_NAME = "s2ag"
CONTEXT = "S2AG"
"""Translation context of our texts, because Blender's own catalogue translates some of the words in other senses."""
_FOLDER = Path(__file__).parent
_MAX_CACHED = 1000
_PACKAGE = cast(str, __package__).rpartition(".")[0]


def _tables(folder: Path) -> dict[str, dict[str, str]]:
    """Load the tables of a folder, by locale; what has no translation yet, ``""``, is left out."""
    read = {path.stem: json.loads(path.read_text("utf-8")) for path in sorted(folder.glob("*.json"))}
    return {locale: {text: told for text, told in table.items() if told} for locale, table in read.items()}


LANGUAGES = _tables(_FOLDER)
"""Locale -> ``{message: translation}`` of the interface, from one JSON file per language."""
STYLES = _tables(_FOLDER / "styles")
"""Locale -> translations of the names of the shipped styles."""


def _ours(locale: str) -> str:
    """Return the table for Blender's locale, which may name another country (de_AT) where it follows the system."""
    language = locale.partition("_")[0]
    return next((one for one in LANGUAGES if one == locale or language not in ("", "zh") and one.startswith(language)), "")


@functools.cache
def errors(locale: str) -> dict[str, str]:
    """Return the translations of error sentences, with ``{}`` for each inserted name or number; empty without a table."""
    return _tables(_FOLDER / "errors").get(locale, {})


@functools.lru_cache(maxsize=_MAX_CACHED)
def translate_sentence(locale: str, text: str) -> str:
    """Translate a sentence that fits a template of :func:`errors`, the longest one; return ``text`` if none fits."""
    longest, filled = -1, text
    for template, translated in errors(locale).items():
        fixed = template.split("{}")
        length = len("".join(fixed))
        if length > longest and (match := re.fullmatch("(.*)".join(map(re.escape, fixed)), text, re.DOTALL)):
            longest, filled = length, translated.format(*match.groups())
    return filled


def translate(text: str, **values: object) -> str:
    """Translate a sentence into the user's language and fill its ``{names}`` with ``values``."""
    translated = cast(str, bpy.app.translations.pgettext_rpt(text, CONTEXT))
    if values:
        return translated.format(**values)
    locale = _ours(bpy.app.translations.locale) if translated == text else ""
    return translate_sentence(locale, text) if locale else translated


def translate_style(style: str) -> str:
    """Translate a style's name, if the user's preferences say to translate names of new data."""
    label = style.capitalize()
    translated = cast(str, bpy.app.translations.pgettext_data(label, CONTEXT))
    return style if translated == label else translated


def translate_error(error: S2agError) -> str:
    """Translate an error and its remedy into one line; remedies of the command line become those of the panel."""
    if "s2ag rig" in error.remedy:
        return f"{translate(error.message)} {translate('Choose its bones in the panel Bone Map.')}"
    return f"{translate(error.message)} {translate(error.remedy)}".strip()


def set_translation_context(cls: type) -> None:
    """Set our translation context on a class to be registered, and on its properties and their enum items."""
    if issubclass(cls, (bpy.types.Panel, bpy.types.Operator, bpy.types.Menu)):
        cls.bl_translation_context = CONTEXT
    for base in cls.__mro__:
        if base.__module__.startswith(_PACKAGE):
            for declared in getattr(base, "__annotations__", {}).values():
                declared.keywords.setdefault("translation_context", CONTEXT)


def register() -> None:
    """Register every table with Blender, under our own context and, for plain labels, under Blender's."""
    tables: dict[str, Any] = {}
    for locale, table in LANGUAGES.items():
        texts = {**table, **STYLES.get(locale, {})}
        pairs = {(context, message): text for message, text in texts.items() for context in ("*", "Operator", CONTEXT)}
        tables[locale] = pairs
        if not locale.startswith("zh"):  # Traditional Chinese is another language
            tables[locale.partition("_")[0]] = pairs
    bpy.app.translations.register(_NAME, tables)


def unregister() -> None:
    """Unregister the tables."""
    bpy.app.translations.unregister(_NAME)
