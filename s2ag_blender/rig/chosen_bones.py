"""Reads the bones that the animator chose for each part, stored in a character's settings as text."""

import csv
from collections.abc import Iterable
from typing import Any

from ...core import json_text
from ...rigs import maps
from ...rigs.skeleton import Mapping


def mapping_of_settings(settings: Any) -> Mapping | dict[str, tuple[str, ...]] | None:
    """Return the bones chosen by hand as ``{part: bones}``, a bone map from a file as a mapping, or None for detection.

    Raises :class:`RigUnusable` where a file's map was edited so that a bone belongs to two parts."""
    if not settings.bone_map:
        return None
    chains = {item.name: chain for item in settings.bone_map if (chain := split(item.bones))}
    notes = getattr(settings, "bone_map_notes", "")  # takes of earlier versions have none
    if not notes:
        return chains
    return maps.parse({part: list(chain) for part, chain in chains.items()} | _parse_notes(notes))


def _parse_notes(notes: str) -> dict[str, Any]:
    """Return the entries of a map other than bones; {} for invalid JSON."""
    try:
        entries = json_text.parse(notes, maps.LARGEST)
    except json_text.NotJson:
        return {}
    return entries if isinstance(entries, dict) else {}


def split(text: str) -> tuple[str, ...]:
    """Return the bones in a text field, separated by commas; names with commas or quotes are in double quotes."""
    names = next(csv.reader([text], skipinitialspace=True), [])
    return tuple(name.strip() for name in names if name.strip())


def join(bones: Iterable[str]) -> str:
    """Return bones as a text field that :func:`split` reads."""
    return ", ".join(f'"{bone.replace(chr(34), chr(34) * 2)}"' if set(bone) & set(',"') else bone for bone in bones)
