"""Stores the face map that the user chose for a character, as JSON in a custom property."""

from ...core.errors import RigUnusable
from ...rigs.faces import shapes
from ..datablocks import ArmatureObject

OWN = "s2ag_face_map"
"""Custom property of an armature object: the JSON of a face map."""


def read_face_map(armature: ArmatureObject) -> shapes.Shapes | None:
    """Return the chosen face map, or None where shape keys are to be detected by name."""
    text = armature.get(OWN)
    if not isinstance(text, str):
        return None
    try:
        return shapes.parse(text)
    except RigUnusable:
        return None  # anybody may have written the property


def store_face_map(armature: ArmatureObject, face: shapes.Shapes | None) -> None:
    """Set the face map of a character; None restores detection by name."""
    if face is not None:
        armature[OWN] = shapes.dump(face)
    elif OWN in armature:
        del armature[OWN]
