"""The human's armature and skin weights, from the rig definitions of the data package."""

import re

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from . import data

CURL = {1: (8, 12, 8), 2: (14, 20, 12), 3: (18, 24, 14), 4: (22, 26, 16), 5: (26, 28, 16)}
"""Degrees by which each finger's three joints bend in a relaxed hand, thumb first."""


def armature(name: str, rig: str, points: np.ndarray, collection):
    """The armature object of the rig called ``rig``, fitted to ``points`` (19158, 3)."""
    bones, _ = data.rig(rig)
    skeleton = bpy.data.armatures.new(name)
    item = bpy.data.objects.new(name, skeleton)
    collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, definition in bones.items():
        edit = skeleton.edit_bones.new(bone)
        edit.head, edit.tail = (place(definition[end], points) for end in ("head", "tail"))
        edit.roll = definition["roll"]
    for bone, definition in bones.items():
        if definition["parent"]:
            edit = skeleton.edit_bones[bone]
            edit.parent = skeleton.edit_bones[definition["parent"]]
            edit.use_connect = bool(definition["use_connect"])
            edit.use_inherit_rotation = definition["use_inherit_rotation"]
    bpy.ops.object.mode_set(mode="OBJECT")
    return item


def place(end: dict, points: np.ndarray) -> np.ndarray:
    """Where a bone's end lies (3,): the centre of a joint cube, a vertex or a mean of vertices."""
    if end["strategy"] == "CUBE":
        return data.base_mesh().joint(end["cube_name"], points)
    if end["strategy"] == "VERTEX":
        return points[end["vertex_index"]]
    return points[end["vertex_indices"]].mean(0)


def weights(rig: str) -> tuple[list[str], np.ndarray]:
    """Names of the deforming bones and weights (19158, bones) float32 that add up to one at every skinned vertex."""
    _, groups = data.rig(rig)
    names = [name for name, pairs in groups.items() if pairs]
    table = np.zeros((len(data.base_mesh().points), len(names)), np.float32)
    for column, name in enumerate(names):
        rows, values = np.array(groups[name]).T
        table[rows.astype(int), column] = values
    total = table.sum(1, keepdims=True)
    return names, np.divide(table, total, out=table, where=total > 0)


def relax_hands(armature, points: np.ndarray) -> None:
    """Bend the fingers of a rig into a hand at ease, as a pose that no gesture keys."""
    mesh = data.base_mesh()
    for side in "lr":
        joint = {
            (finger, link): mesh.joint(f"joint-{side}-finger-{finger}-{link}", points)
            for finger in range(1, 6)
            for link in range(1, 5)
        }
        knuckles = joint[5, 1] - joint[2, 1]
        reach = joint[3, 4] - joint[3, 1]
        palm = np.cross(reach, knuckles) * (1 if side == "l" else -1)
        for (finger, link), place in joint.items():
            bone = _bone_at(armature, place) if link < 4 else None
            if bone is None:
                continue
            along = joint[finger, link + 1] - place
            axis = np.cross(along, palm)
            _turn(bone, axis / np.linalg.norm(axis), np.radians(CURL[finger][link - 1]))


def _bone_at(armature, place: np.ndarray):
    """The pose bone that starts at ``place`` (3,), within two millimetres, or None."""
    near = [bone for bone in armature.pose.bones if (bone.bone.head_local - Vector(place)).length < 0.002]
    return near[0] if near else None


def _turn(bone, axis: np.ndarray, angle: float) -> None:
    """Rotate a pose bone about an axis given in armature space, in its own rotation mode."""
    rest = bone.bone.matrix_local.to_quaternion()
    turned = rest.inverted() @ Quaternion(Vector(axis), angle) @ rest
    bone.matrix_basis = Matrix.LocRotScale(None, turned, None)
