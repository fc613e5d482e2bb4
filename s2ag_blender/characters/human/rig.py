"""Builds the human's armature from the packed rig definitions, and relaxes its hands."""

from typing import cast

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ...datablocks import ArmatureObject, current_context
from . import data

CURL = {1: (16, 4, 10), 2: (14, 20, 12), 3: (18, 24, 14), 4: (22, 26, 16), 5: (26, 28, 16)}
"""Degrees by which each finger's three joints bend in a relaxed hand, thumb first; the thumb's root turns to the index."""

WRIST = 0.6
"""Share of the base mesh's backward bend between forearm and hand that a relaxed wrist straightens."""


def armature(name: str, rig: str, points: np.ndarray, collection: bpy.types.Collection) -> ArmatureObject:
    """Create the armature object of the rig called ``rig``, fitted to ``points`` (19158, 3)."""
    bones = data.rig(rig)
    skeleton = bpy.data.armatures.new(name)
    item = cast(ArmatureObject, bpy.data.objects.new(name, skeleton))
    collection.objects.link(item)
    current_context().view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, definition in bones.items():
        edit = skeleton.edit_bones.new(bone)
        edit.head, edit.tail = (place(definition[end], points).tolist() for end in ("head", "tail"))
        edit.roll = definition["roll"]
    for bone, definition in bones.items():
        if definition["parent"]:
            edit = skeleton.edit_bones[bone]
            edit.parent = skeleton.edit_bones[definition["parent"]]
            edit.use_connect = definition["connect"]
            edit.use_inherit_rotation = definition["inherit"]
    bpy.ops.object.mode_set(mode="OBJECT")
    return item


def place(end: str | list[int], points: np.ndarray) -> np.ndarray:
    """Return the position (3,) of a bone's end: the centre of a joint, a point or a mean of points."""
    return data.base_mesh().joint(end, points) if isinstance(end, str) else points[end].mean(0)


def relax_hands(armature: ArmatureObject, points: np.ndarray) -> None:
    """Straighten the wrists and bend the fingers to relaxed hands, as a pose that only motions with hands replace."""
    mesh = data.base_mesh()
    for side in "lr":
        elbow, wrist = (mesh.joint(f"joint-{side}-{name}", points) for name in ("elbow", "hand"))
        joint = {
            (finger, link): mesh.joint(f"joint-{side}-finger-{finger}-{link}", points)
            for finger in range(1, 6)
            for link in range(1, 5)
        }
        swing = Vector(joint[3, 1] - wrist).rotation_difference(Vector(wrist - elbow))
        hand = _bone_at(armature, wrist)
        if hand is not None:
            _turn(hand, Quaternion().slerp(swing, WRIST))
        palm = np.cross(joint[3, 4] - joint[3, 1], joint[5, 1] - joint[2, 1]) * (-1 if side == "l" else 1)
        for (finger, link), place in joint.items():
            bone = _bone_at(armature, place) if link < 4 else None
            if bone is not None:
                along = joint[finger, link + 1] - place
                axis = np.cross(along, joint[2, 1] - place if (finger, link) == (1, 1) else palm)
                _turn(bone, Quaternion(Vector(axis).normalized(), np.radians(CURL[finger][link - 1])))


def _bone_at(armature: ArmatureObject, place: np.ndarray) -> bpy.types.PoseBone | None:
    """Return the pose bone that starts within two millimetres of ``place`` (3,), or None."""
    point = Vector(place.tolist())
    near = [bone for bone in armature.pose.bones if (bone.bone.head_local - point).length < 0.002]
    return near[0] if near else None


def _turn(bone: bpy.types.PoseBone, turn: Quaternion) -> None:
    """Rotate a pose bone by a rotation in armature space."""
    rest = bone.bone.matrix_local.to_quaternion()
    bone.matrix_basis = Matrix.LocRotScale(None, rest.inverted() @ turn @ rest, None)
