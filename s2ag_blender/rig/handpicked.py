"""Bones that the animator chose, as a character's settings keep them: a field of text for each part."""

import csv

from ...core import json_text
from ...rigs import maps
from ...rigs.plain import Mapping


def chosen(settings) -> Mapping | dict[str, tuple[str, ...]] | None:
    """The bones that were chosen by hand, ``{part: bones}``; those of a file as the mapping it says; None for the found ones.

    Raises :class:`RigUnusable` where a file's map was edited so that a bone is two parts.
    """
    if not settings.bone_map:
        return None
    chains = {item.name: chain for item in settings.bone_map if (chain := split(item.bones))}
    notes = getattr(settings, "bone_map_notes", "")  # takes of earlier versions have none
    if not notes:
        return chains
    return maps.parse({part: list(chain) for part, chain in chains.items()} | _noted(notes))


def _noted(notes: str) -> dict:
    """What a map says beside bones; a text that another has changed says nothing."""
    try:
        found = json_text.parse(notes, maps.LARGEST)
    except json_text.NotJson:
        return {}
    return found if isinstance(found, dict) else {}


def split(text: str) -> tuple[str, ...]:
    """The bones in a field, with commas between; a name that has commas or quotes itself stands in quotes."""
    names = next(csv.reader([text], skipinitialspace=True), [])
    return tuple(name.strip() for name in names if name.strip())


def join(bones) -> str:
    """Bones as a field that :func:`split` reads."""
    return ", ".join(f'"{bone.replace(chr(34), chr(34) * 2)}"' if set(bone) & set(',"') else bone for bone in bones)
