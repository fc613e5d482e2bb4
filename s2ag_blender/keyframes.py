"""Rotations to keyframes in bulk: a new action, one curve at a time, whole arrays at once."""

import json
from dataclasses import dataclass

import bpy
import numpy as np

from .. import __version__
from ..rigs import quaternion
from . import compat

PROVENANCE = "s2ag"
FORMER = "s2ag_former"
"""Names of the custom properties of an action that hold, as JSON text, its provenance and what its keys replaced."""


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
        if not bone.lock_rotations_4d:
            rotations = quaternion.continuous(held(bone, rotations))
        if mode == "QUATERNION":
            values, name = rotations, "rotation_quaternion"
        else:
            values, name = quaternion.to_axis_angle(rotations), "rotation_axis_angle"
    path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].{name}'
    return Channels(bone.name, path, {index: values[:, index] for index in range(values.shape[1]) if not locks[index]})


def held(bone: bpy.types.PoseBone, rotations: np.ndarray) -> np.ndarray:
    """Rotations ``(frames, 4)`` as a bone at rest takes them where some of its channels are locked."""
    if not any(bone.lock_rotation):
        return rotations
    order = bone.rotation_mode
    if order not in quaternion.EULER_ORDERS:
        if bone.lock_rotations_4d:
            locks = np.array([bone.lock_rotation_w, *bone.lock_rotation])
            kept = np.where(locks, quaternion.IDENTITY, rotations)
            return kept / np.maximum(np.linalg.norm(kept, axis=-1, keepdims=True), 1e-9)
        order = "XYZ"
    angles = quaternion.to_euler(rotations, order) * [not lock for lock in bone.lock_rotation]
    return quaternion.from_euler(angles, order)


def write_action(
    name: str,
    armature: bpy.types.Object,
    rotations: dict[str, np.ndarray],
    frames: np.ndarray,
    interpolation: str = "LINEAR",
    settings: dict[str, float] | None = None,
) -> tuple[bpy.types.Action, object]:
    """A new action (and its slot) with ``rotations`` ``{bone: (frames, 4)}`` keyed at scene ``frames`` ``(frames,)``.

    A bone with a single rotation, and the ``settings`` by data path, get one constant key at the first frame. Curves are
    grouped by bone and marked as generated; nothing is assigned yet.
    """
    action, slot, bag = compat.new_action(name, armature)
    once, style = _key_style(1, "CONSTANT"), _key_style(len(frames), interpolation)
    for path, value in (settings or {}).items():
        _fill(bag.fcurves.new(path, index=0), frames[:1], np.array([value]), once)
    for bone, values in rotations.items():
        keyed = channels(armature.pose.bones[bone], values)
        if not keyed.values:
            continue
        group = bag.groups.new(keyed.bone)
        for index, column in keyed.values.items():
            curve = bag.fcurves.new(keyed.path, index=index)
            curve.group = group
            still = len(column) < len(frames)
            _fill(curve, frames[: len(column)], column, once if still else style)
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


def remember(action: bpy.types.Action, armature: bpy.types.Object) -> None:
    """Store what ``armature`` has now of all that ``action`` keys."""
    values = {path: armature.path_resolve(path) for path in {curve.data_path for curve in compat.curves(action)}}
    plain = {path: list(value) if hasattr(value, "__len__") else value for path, value in values.items()}
    action[FORMER] = json.dumps(plain, sort_keys=True)


def former(action: bpy.types.Action) -> dict:
    """What :func:`remember` stored: values by data path."""
    return json.loads(action.get(FORMER, "{}"))


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
