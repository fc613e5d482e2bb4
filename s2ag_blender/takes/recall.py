"""The settings of a take, kept with its action so that they can be had back."""

from types import SimpleNamespace

import bpy

from ...rigs.goals import Options

_NOT_KEPT = {"rna_type", "name", "takes", "active_take", "bone_map", "style_pick", "style_second_pick", "transcript_block"}
_NOT_KEPT |= {"target", "partner"}

_KINDS = {"BOOLEAN": bool, "INT": int, "FLOAT": (int, float), "STRING": str, "ENUM": (str, list)}


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
    enums = {one.identifier: one.default for one in every if one.type == "ENUM" and not one.is_enum_flag}
    parts = {"parts": set(every["parts"].default_flag)}
    bones = [SimpleNamespace(name=part, bones=chain) for part, chain in _bones(kept).items()]
    known = {name: set(value) if every[name].type == "ENUM" and every[name].is_enum_flag else value
             for name, value in _sensible(every, kept).items()}  # fmt: skip
    return SimpleNamespace(**{**plain, **enums, **parts, **known, "bone_map": bones, "transcript_block": _block(kept)})


def options(settings) -> Options:
    """How motions are laid onto a character, from its settings."""
    return Options(
        torso=settings.torso_strength if "TORSO" in settings.parts else 0.0,
        head=settings.head_strength if "HEAD" in settings.parts else 0.0,
        clavicle=settings.clavicle_strength if "CLAVICLES" in settings.parts else 0.0,
        palms=settings.palms,
    )


def restore(settings, kept: dict) -> None:
    """Set a character's settings to what :func:`snapshot` gave; what this version does not know is left out."""
    known = settings.bl_rna.properties
    for name, value in _sensible(known, kept).items():
        if known[name].is_readonly:
            continue
        if known[name].type == "ENUM":
            choices = set(known[name].enum_items.keys())
            value = set(value) & choices if known[name].is_enum_flag else value
            if not known[name].is_enum_flag and value not in choices:
                continue
        setattr(settings, name, value)
    settings.transcript_block = _block(kept)
    settings.bone_map_notes = notes if isinstance(notes := kept.get("bone_map_notes"), str) else ""
    settings.bone_map.clear()
    for part, bones in _bones(kept).items():
        item = settings.bone_map.add()
        item.name, item.bones = part, bones


def _sensible(properties, kept: dict) -> dict:
    """What of ``kept`` is a setting and of its kind: a file may have been changed by others."""
    found = {}
    for name, value in kept.items():
        kind = _KINDS.get(properties[name].type) if name in properties and name not in _NOT_KEPT else None
        if kind is None or not isinstance(value, kind) or isinstance(value, bool) != (kind is bool):
            continue
        if isinstance(value, list) != bool(properties[name].type == "ENUM" and properties[name].is_enum_flag):
            continue
        if isinstance(value, (int, float)) and not abs(value) < 2**31:  # nor is what is no number
            continue
        if not isinstance(value, list) or all(isinstance(one, str) for one in value):
            found[name] = value
    return found


def _bones(kept: dict) -> dict[str, str]:
    """The fields of the bone map that were kept."""
    bones = kept.get("bone_map")
    return {part: chain for part, chain in bones.items() if isinstance(chain, str)} if isinstance(bones, dict) else {}


def _block(kept: dict):
    """The text that was the transcript, if it is still there."""
    name = kept.get("transcript_block")
    return bpy.data.texts.get(name) if isinstance(name, str) else None


def _plain(value):
    if isinstance(value, set):
        return sorted(value)
    return round(value, 4) if isinstance(value, float) else value  # Blender keeps 0.8 as 0.800000012
