"""Rotations to keyframes in bulk: a new action, one curve at a time, whole arrays at once."""

import json
from dataclasses import dataclass

import bpy
import numpy as np

from .. import __version__
from ..rigs import quaternion
from . import compat

PROVENANCE = "s2ag"
"""Name of the custom property of an action that holds its provenance as JSON text."""


@dataclass(frozen=True)
class Channels:
    """What to key on one bone: a property's path below the object, and values (frames,) for each free index."""

    bone: str
    path: str
    values: dict[int, np.ndarray]


def channels(bone: bpy.types.PoseBone, rotations: np.ndarray) -> Channels:
    """Rotations ``(frames, 4)`` of a bone in the rotation mode it has, without its locked channels.

    Euler angles and quaternion signs do not jump. Where a quaternion bone has single axes locked, those Euler axes are
    held at rest, as Blender's own tools do.
    """
    mode = bone.rotation_mode
    if mode in quaternion.EULER_ORDERS:
        values, locks, name = quaternion.to_euler(rotations, mode), bone.lock_rotation, "rotation_euler"
    else:
        locks = [bone.lock_rotation_w, *bone.lock_rotation] if bone.lock_rotations_4d else [all(bone.lock_rotation)] * 4
        if any(bone.lock_rotation) and not bone.lock_rotations_4d:
            angles = quaternion.to_euler(rotations, "XYZ") * [not lock for lock in bone.lock_rotation]
            rotations = quaternion.continuous(quaternion.from_euler(angles))
        if mode == "QUATERNION":
            values, name = rotations, "rotation_quaternion"
        else:
            values, name = quaternion.to_axis_angle(rotations), "rotation_axis_angle"
    path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].{name}'
    return Channels(bone.name, path, {index: values[:, index] for index in range(values.shape[1]) if not locks[index]})


def write_action(
    name: str, armature: bpy.types.Object, rotations: dict[str, np.ndarray], frames: np.ndarray, interpolation: str = "LINEAR"
) -> tuple[bpy.types.Action, object]:
    """A new action (and its slot) with ``rotations`` ``{bone: (frames, 4)}`` keyed at scene ``frames`` ``(frames,)``.

    Curves are grouped by bone and marked as generated; nothing is assigned yet.
    """
    action, slot, bag = compat.new_action(name, armature)
    style = _key_style(len(frames), interpolation)
    for bone, values in rotations.items():
        keyed = channels(armature.pose.bones[bone], values)
        if not keyed.values:
            continue
        group = bag.groups.new(keyed.bone)
        for index, column in keyed.values.items():
            curve = bag.fcurves.new(keyed.path, index=index)
            curve.group = group
            _fill(curve, frames, column, style)
    action.use_frame_range = True
    action.frame_start, action.frame_end = float(frames[0]), float(frames[-1])
    return action, slot


def stamp(action: bpy.types.Action, meta: dict) -> None:
    """Store where a motion came from on its action, with this package's version."""
    action[PROVENANCE] = json.dumps({**meta, "version": __version__}, sort_keys=True)


def provenance(action: bpy.types.Action) -> dict | None:
    """What :func:`stamp` stored, or None if this package did not make the action."""
    text = action.get(PROVENANCE)
    return None if text is None else json.loads(text)


def _key_style(count: int, interpolation: str) -> dict[str, np.ndarray]:
    """Key properties that hold for every key, as arrays that Blender takes in one go."""
    properties = bpy.types.Keyframe.bl_rna.properties
    chosen = {"interpolation": interpolation, "type": "GENERATED"}
    if interpolation == "BEZIER":
        chosen |= {"handle_left_type": "AUTO_CLAMPED", "handle_right_type": "AUTO_CLAMPED"}
    return {key: np.full(count, properties[key].enum_items[value].value, np.int32) for key, value in chosen.items()}


def _fill(curve: bpy.types.FCurve, frames: np.ndarray, values: np.ndarray, style: dict[str, np.ndarray]) -> None:
    points = curve.keyframe_points
    points.add(len(frames))
    points.foreach_set("co", np.stack([frames, values], -1).astype(np.float32).ravel())
    for key, column in style.items():
        points.foreach_set(key, column)
    curve.update()
