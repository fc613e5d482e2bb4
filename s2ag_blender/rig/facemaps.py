"""The map of a face that was chosen for a character, kept with it as the JSON that files have."""

import bpy

from ...core.errors import RigUnusable
from ...rigs.faces import shapes

OWN = "s2ag_face_map"
"""Custom property of an armature object: the JSON of a map."""


def chosen(armature: bpy.types.Object) -> shapes.Shapes | None:
    """The map that was chosen, or None where faces are found by name."""
    text = armature.get(OWN)
    if not isinstance(text, str):
        return None
    try:
        return shapes.parse(text)
    except RigUnusable:
        return None  # whoever wrote the property: what makes no sense is nothing


def choose(armature: bpy.types.Object, face: shapes.Shapes | None) -> None:
    """Let a character have this face, or, with None, the one that is found."""
    if face is not None:
        armature[OWN] = shapes.dump(face)
    elif OWN in armature:
        del armature[OWN]
