"""Detects a character's face: which shape keys and bones show which part of a facial expression."""

from dataclasses import dataclass, field

import bpy

from ...core.errors import RigUnusable
from ...rigs.faces import bones as face_bones
from ...rigs.faces import shapes
from ...rigs.skeleton import Mapping
from ..datablocks import ArmatureObject
from ..rig import facemaps, reading
from . import loading

_BONES: dict[tuple[int, int], dict[str, str]] = {}
"""Cache: ``{(session_uid of the character, number of its bones): {part: bone}}``."""


@dataclass(frozen=True)
class CharacterFace:
    """A character's face: its map of shape keys, the datablocks that have them, and bones for parts without shape keys."""

    shapes: shapes.Shapes
    keys: tuple[bpy.types.Key, ...]
    bones: dict[str, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[str]:
        """Return the display names of the parts of the face that nothing shows."""
        return self.shapes.missing(face_bones.shown_channels(self.bones))


def find(armature: ArmatureObject, mapping: Mapping | None = None, look: bool = True) -> CharacterFace | None:
    """Find the face of a character, by its chosen map or by the names of shape keys and bones; None if it has no mouth.

    ``mapping`` is that of its body, if known. Without ``look`` (for drawing) cached bones are used."""
    blocks, chosen = keys(armature), facemaps.read_face_map(armature)
    face = chosen or shapes.detect(tuple(block.name for key in blocks for block in key.key_blocks))
    parts = _parts(armature, chosen, mapping, look)
    used = face_bones.needed_parts(parts, None if chosen is None and face is None else face)
    if face is None and "jaw" not in used:
        return None
    face = face or shapes.Shapes("bones", {}, ("PP",))
    speaking = tuple(key for key in blocks if any(name in key.key_blocks for name in face.keys))
    return CharacterFace(face, speaking, used) if speaking or used else None


def face_map(armature: ArmatureObject) -> shapes.Shapes | None:
    """Return the face of a character as a map to write to a file: its shape keys and all its facial bones."""
    found = find(armature)
    if found is None:
        return None
    parts = {name: dict(weights) for name, weights in found.shapes.keys.items()}
    return shapes.Shapes(
        found.shapes.family, parts, found.shapes.rest, bones=_parts(armature, facemaps.read_face_map(armature))
    )


def _parts(
    armature: ArmatureObject, chosen: shapes.Shapes | None, mapping: Mapping | None = None, look: bool = True
) -> dict[str, str]:
    """Return the bones of the face by part."""
    if chosen is not None:
        return {part: name for part, name in chosen.bones.items() if name in armature.data.bones}
    key = armature.session_uid, len(armature.data.bones)
    if look or key not in _BONES:
        bones = reading.read(armature)
        try:
            _BONES[key] = face_bones.find(bones, mapping or reading.resolve_mapping(armature, bones))
        except RigUnusable:  # the readiness of the body reports why
            _BONES[key] = {}
    return _BONES[key]


def keys(armature: ArmatureObject) -> list[bpy.types.Key]:
    """Return the shape key datablocks of all meshes of a character, sorted by name."""
    datablocks = {mesh.data.shape_keys for mesh in loading.meshes(armature) if mesh.data.shape_keys is not None}
    return sorted(datablocks, key=lambda key: key.name)
