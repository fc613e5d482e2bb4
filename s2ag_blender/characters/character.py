"""A character in the scene: an armature, the meshes that it deforms, and their collection."""

from dataclasses import dataclass

import bpy

from ...rigs.skeleton import Mapping
from ..datablocks import ArmatureObject, MeshObject


@dataclass(frozen=True)
class Character:
    """``armature`` is the armature object to animate, ``meshes`` the objects that it deforms.

    ``mapping`` says which bones are which parts of the body; it is detected if None. ``disarmed`` are sentences about what
    its file would have run or written (:mod:`scene_safety`)."""

    armature: ArmatureObject
    meshes: tuple[MeshObject, ...] = ()
    collection: bpy.types.Collection | None = None
    mapping: Mapping | None = None
    disarmed: tuple[str, ...] = ()
