"""A character in the scene: an armature, the meshes it moves, and the collection they live in."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Character:
    """``armature`` is the armature object to animate, ``meshes`` the objects it deforms, ``collection`` may be None."""

    armature: object
    meshes: tuple = ()
    collection: object = None
