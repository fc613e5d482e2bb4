"""Stores a character's settings with a take's action, and restores them."""

from types import SimpleNamespace
from typing import Any

import bpy

from ...rigs.goals import Options

_NOT_STORED = {"rna_type", "name", "takes", "active_take", "bone_map", "style_pick", "style_second_pick", "transcript_block"}
_NOT_STORED |= {"target", "partner"}
"""Properties that are not stored, or in a form of their own."""

_TYPES = {"BOOLEAN": bool, "INT": int, "FLOAT": (int, float), "STRING": str, "ENUM": (str, list)}


def snapshot(settings: Any) -> dict[str, Any]:
    """Return all of a character's settings as JSON."""
    stored: dict[str, Any] = {}
    for prop in settings.bl_rna.properties:
        if prop.identifier in _NOT_STORED:
            continue
        stored[prop.identifier] = _as_json(getattr(settings, prop.identifier))
    stored["transcript_block"] = settings.transcript_block.name if settings.transcript_block else ""
    stored["bone_map"] = {item.name: item.bones for item in settings.bone_map}
    return stored


def settings_view(stored: dict) -> SimpleNamespace:
    """Return a read-only copy of the settings that :func:`snapshot` stored; no character is changed.

    Settings that an older version did not have get their defaults."""
    group: Any = bpy.types.Object.bl_rna.properties["s2ag"]
    every = group.fixed_type.properties
    plain = {one.identifier: one.default for one in every if one.type in ("BOOLEAN", "INT", "FLOAT", "STRING")}
    choices = [one for one in every if one.type == "ENUM" and one.identifier not in _NOT_STORED]  # menus have no default
    enums = {one.identifier: one.default for one in choices if not one.is_enum_flag}
    parts = {"parts": set(every["parts"].default_flag)}
    bones = [SimpleNamespace(name=part, bones=chain) for part, chain in _bones(stored).items()]
    values = {name: set(value) if every[name].type == "ENUM" and every[name].is_enum_flag else value
              for name, value in _valid(every, stored).items()}  # fmt: skip
    return SimpleNamespace(**{**plain, **enums, **parts, **values, "bone_map": bones, "transcript_block": _block(stored)})


def options(settings: Any) -> Options:
    """Return the options of retargeting motions onto a character, from its settings."""
    return Options(
        torso=settings.torso_strength if "TORSO" in settings.parts else 0.0,
        head=settings.head_strength if "HEAD" in settings.parts else 0.0,
        clavicle=settings.clavicle_strength if "CLAVICLES" in settings.parts else 0.0,
        palms=settings.palms,
        seated=settings.seated,
        table=settings.table,
    )


def restore(settings: Any, stored: dict) -> None:
    """Set a character's settings to those that :func:`snapshot` stored, ignoring ones that this version lacks."""
    properties = settings.bl_rna.properties
    for name, value in _valid(properties, stored).items():
        if properties[name].is_readonly:
            continue
        if properties[name].type == "ENUM":
            choices = set(properties[name].enum_items.keys())
            value = set(value) & choices if properties[name].is_enum_flag else value
            if not properties[name].is_enum_flag and value not in choices:
                continue
        setattr(settings, name, value)
    settings.transcript_block = _block(stored)
    settings.bone_map_notes = notes if isinstance(notes := stored.get("bone_map_notes"), str) else ""
    settings.bone_map.clear()
    for part, bones in _bones(stored).items():
        item = settings.bone_map.add()
        item.name, item.bones = part, bones


def _valid(properties: Any, stored: dict) -> dict[str, Any]:
    """Return the items of ``stored`` that are settings with values of their types; files may be damaged or foreign."""
    valid = {}
    for name, value in stored.items():
        kind = _TYPES.get(properties[name].type) if name in properties and name not in _NOT_STORED else None
        if kind is None or not isinstance(value, kind) or isinstance(value, bool) != (kind is bool):
            continue
        if isinstance(value, list) != bool(properties[name].type == "ENUM" and properties[name].is_enum_flag):
            continue
        if isinstance(value, (int, float)) and not abs(value) < 2**31:  # too large, infinite or not a number
            continue
        if not isinstance(value, list) or all(isinstance(one, str) for one in value):
            valid[name] = value
    return valid


def _bones(stored: dict) -> dict[str, str]:
    """Return the stored fields of the bone map."""
    bones = stored.get("bone_map")
    return {part: chain for part, chain in bones.items() if isinstance(chain, str)} if isinstance(bones, dict) else {}


def _block(stored: dict) -> bpy.types.Text | None:
    """Return the text block of the transcript, if it still exists."""
    name = stored.get("transcript_block")
    return bpy.data.texts.get(name) if isinstance(name, str) else None


def _as_json(value: Any) -> Any:
    if isinstance(value, set):
        return sorted(value)
    return round(value, 4) if isinstance(value, float) else value  # Blender stores 0.8 as 0.800000012
