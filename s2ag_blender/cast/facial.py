"""The face that a character has: which shape keys and bones of it show what."""

from dataclasses import dataclass, field

import bpy

from ...core.errors import RigUnusable
from ...rigs.faces import bones as face_bones
from ...rigs.faces import shapes
from ...rigs.plain import Mapping
from ..datablocks import ArmatureObject
from ..rig import facemaps, reading
from . import cast

_BONES: dict[tuple, dict[str, str]] = {}  # a character's number in this session and of its bones -> bones by part


@dataclass(frozen=True)
class Found:
    """A character's face: which of its keys show what, the datablocks that have them, and bones for what no key shows."""

    shapes: shapes.Shapes
    keys: tuple[bpy.types.Key, ...]
    bones: dict[str, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[str]:
        """Parts of the face that nothing shows, by their names for people."""
        return self.shapes.missing(face_bones.shown(self.bones))


def find(armature: ArmatureObject, mapping: Mapping | None = None, look: bool = True) -> Found | None:
    """The face of a character, by its own map or by the names of its shape keys and bones; None where nothing speaks.

    ``mapping`` is that of its body, if it is known. For drawing, without a ``look``, bones are those that were found last.
    """
    blocks, given = keys(armature), facemaps.chosen(armature)
    known = given or shapes.detect({block.name: None for key in blocks for block in key.key_blocks}.keys())
    parts = _parts(armature, given, mapping, look)
    used = face_bones.needed(parts, None if given is None and known is None else known)
    if known is None and "jaw" not in used:
        return None
    known = known or shapes.Shapes("bones", {}, ("PP",))
    speaking = tuple(key for key in blocks if any(name in key.key_blocks for name in known.keys))
    return Found(known, speaking, used) if speaking or used else None


def whole(armature: ArmatureObject) -> shapes.Shapes | None:
    """The face of a character as a map that can be written: its keys and all its bones."""
    found = find(armature)
    if found is None:
        return None
    parts = {name: dict(weights) for name, weights in found.shapes.keys.items()}
    return shapes.Shapes(found.shapes.family, parts, found.shapes.rest, bones=_parts(armature, facemaps.chosen(armature)))


def told_of(armature: ArmatureObject) -> dict:
    """``table``, what shows each part of the face as lines of text, and ``map``, the face as a map's JSON, or None."""
    found = find(armature)
    if found is None:
        return {"table": "no shape keys or bones that speak were found", "map": None}
    by_key = {
        part: [key for key, ways in found.shapes.keys.items() if _shows(ways, names)] for part, names in shapes.PARTS.items()
    }
    by_bone = {
        part: [one for key, one in found.bones.items() if face_bones.shown([key]) & set(names)]
        for part, names in shapes.PARTS.items()
    }
    missing = set(found.missing)
    lines = [f"{found.shapes.family}, {len(found.shapes.keys)} keys, {len(found.bones)} bones"]
    for part in shapes.PARTS:
        what = [*by_key[part], *by_bone[part]]
        by_rest = "by other parts or at rest"
        lines.append(
            f"  {part:<23}{'missing' if part in missing else ', '.join(what[:4]) + (' ...' if what[4:] else '') or by_rest}"
        )
    return {"table": "\n".join(lines), "map": shapes.dump(whole(armature))}


def _shows(ways: dict, names) -> bool:
    return bool({name.rstrip("+-") for name, weight in ways.items() if weight} & set(names))


def _parts(armature: ArmatureObject, given, mapping: Mapping | None = None, look: bool = True) -> dict[str, str]:
    """Bones of the face by part."""
    if given is not None:
        return {part: name for part, name in given.bones.items() if name in armature.data.bones}
    key = armature.session_uid, len(armature.data.bones)
    if look or key not in _BONES:
        bones = reading.read(armature)
        try:
            _BONES[key] = face_bones.find(bones, mapping or reading.resolve_mapping(armature, bones))
        except RigUnusable:  # a body that cannot gesture: its readiness says why
            _BONES[key] = {}
    return _BONES[key]


def keys(armature: ArmatureObject) -> list[bpy.types.Key]:
    """The shape keys of all meshes of a character, by name."""
    found = {mesh.data.shape_keys for mesh in cast.meshes(armature) if mesh.data.shape_keys is not None}
    return sorted(found, key=lambda key: key.name)
