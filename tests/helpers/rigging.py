"""Armatures for the Blender tests, and reading back where their bones point."""

import bpy
import numpy as np
from bodies import Body
from mathutils import Vector
from s2ag.core.motion import skeleton
from s2ag.s2ag_blender.keys.apply import at_scene_frames, scene_fps


def make_armature(body: Body, name: str = "Rig", rename: dict | None = None, seed: int = 0):
    """An armature object with a bone for every joint; axes and rolls have nothing to do with the joints."""
    random = np.random.default_rng(seed)
    data = bpy.data.armatures.new(name)
    item = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    names = {joint: (rename or {}).get(joint, joint) for joint in body.joints}
    for joint, (at, above) in body.joints.items():
        bone = data.edit_bones.new(names[joint])
        bone.head = at
        bone.tail = bone.head + Vector(random.normal(size=3)).normalized() * 8
        bone.roll = random.uniform(-3, 3)
        if above:
            bone.parent = data.edit_bones[names[above]]
    bpy.ops.object.mode_set(mode="OBJECT")
    return item


def scene_motion(motion):
    """Directions (keys, 9, 3) of a motion at the frames of the current scene, in the canonical frame."""
    return at_scene_frames(motion, scene_fps(bpy.context.scene))[1].directions


def evaluated(item, frame: int) -> dict:
    """Posed matrices ``{bone: (4, 4)}`` in armature space at a scene frame."""
    bpy.context.scene.frame_set(frame)
    posed = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return {bone.name: np.array(bone.matrix) for bone in posed.pose.bones}


def directions(item, pairs: dict, frames) -> dict:
    """``{edge: (frames, 3)}`` from bone head to bone head in armature space, read from the evaluated pose."""
    posed = [evaluated(item, frame) for frame in frames]
    result = {}
    for edge, (start, end) in pairs.items():
        along = np.array([pose[end][:3, 3] - pose[start][:3, 3] for pose in posed])
        result[edge] = along / np.linalg.norm(along, axis=-1, keepdims=True)
    return result


def turned(item, bone: str, frames) -> np.ndarray:
    """How a bone turned away from rest in armature space (frames, 3, 3), read from the evaluated pose."""
    rest = np.array(item.data.bones[bone].matrix_local)[:3, :3]
    return np.array([evaluated(item, frame)[bone][:3, :3] @ rest.T for frame in frames])


def in_blender(motion_directions: np.ndarray) -> np.ndarray:
    """Canonical directions in Blender's frame, unit, in double precision."""
    return skeleton.normalize(skeleton.canonical_to_blender(np.asarray(motion_directions, float)))
