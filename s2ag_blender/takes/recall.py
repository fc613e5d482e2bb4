"""The settings of a take, kept with its action so that they can be had back."""

from types import SimpleNamespace

import bpy

_NOT_KEPT = {"rna_type", "name", "takes", "active_take", "bone_map", "style_pick", "style_second_pick", "transcript_block"}


def snapshot(settings) -> dict:
    """All of a character's settings as JSON."""
    kept = {}
    for prop in settings.bl_rna.properties:
        if prop.identifier in _NOT_KEPT:
            continue
        kept[prop.identifier] = _plain(getattr(settings, prop.identifier))
    kept["transcript_block"] = settings.transcript_block.name if settings.transcript_block else ""
    kept["bone_map"] = {item.name: item.bones for item in settings.bone_map}
    return kept


def view(kept: dict) -> SimpleNamespace:
    """Settings to read from, as :func:`snapshot` gave them, without changing those of any character.

    What an older version did not know has its default.
    """
    every = bpy.types.Object.bl_rna.properties["s2ag"].fixed_type.properties
    plain = {one.identifier: one.default for one in every if one.type in ("BOOLEAN", "INT", "FLOAT", "STRING")}
    bones = [SimpleNamespace(name=part, bones=chain) for part, chain in kept.get("bone_map", {}).items()]
    block = bpy.data.texts.get(kept.get("transcript_block", ""))
    return SimpleNamespace(**{**plain, **kept, "parts": set(kept["parts"]), "bone_map": bones, "transcript_block": block})


def restore(settings, kept: dict) -> None:
    """Set a character's settings to what :func:`snapshot` gave; what this version does not know is left out."""
    known = settings.bl_rna.properties
    for name, value in kept.items():
        if name not in known or name in _NOT_KEPT or known[name].is_readonly:
            continue
        if known[name].type == "ENUM":
            choices = set(known[name].enum_items.keys())
            value = set(value) & choices if known[name].is_enum_flag else value
            if not known[name].is_enum_flag and value not in choices:
                continue
        setattr(settings, name, value)
    settings.transcript_block = bpy.data.texts.get(kept.get("transcript_block", ""))
    settings.bone_map_notes = kept.get("bone_map_notes", "")
    settings.bone_map.clear()
    for part, bones in kept.get("bone_map", {}).items():
        item = settings.bone_map.add()
        item.name, item.bones = part, bones


def _plain(value):
    if isinstance(value, set):
        return sorted(value)
    return round(value, 4) if isinstance(value, float) else value  # Blender keeps 0.8 as 0.800000012
