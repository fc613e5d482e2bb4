"""Converts actions of this package between a key on every frame and only the keys that matter."""

import json
from collections.abc import Collection

import bpy
import numpy as np

from ...core.motion import quaternion
from ...rigs.skeleton import Bones, Mapping
from .. import compat, json_properties
from ..datablocks import ArmatureObject
from ..rig import dependencies, reading
from . import key_reduction, keyframes, layers

KEYED = "s2ag_keyed"
"""Name of an action's custom property that holds, as JSON text, the data paths that gestures keyed."""

_STOOD = "s2ag_stood"
"""Custom property: the bones, as a JSON list, that together keep the feet in place."""


def store_keyed_paths(action: bpy.types.Action, keyed: list[keyframes.Channels], stood: Collection[str] = ()) -> None:
    """Store on an action the data paths that gestures key and the bones ``stood`` that keep the feet in place."""
    action[KEYED] = json.dumps(sorted(one.path for one in keyed if one.bone))
    action[_STOOD] = json.dumps(sorted(stood))


def limbs(bones: Bones, mapping: Mapping) -> dict[str, str]:
    """Return ``{bone: "left" or "right"}`` for the bones of the arms and all their descendants."""
    sides = {}
    for side in ("left", "right"):
        arm = {name for part, chain in mapping.chains.items() if part.startswith(side) for name in chain}
        for row, name in enumerate(bones.names):
            if name in arm or sides.get(bones.names[bones.parents[row]] if bones.parents[row] >= 0 else "") == side:
                sides[name] = side
    return sides


def is_dense(action: bpy.types.Action) -> bool:
    """Return whether gestures are keyed on every frame; False for actions without provenance."""
    place = layers.Place.of(action)
    return place is not None and most_keys(action) >= place.last - place.first


def most_keys(action: bpy.types.Action) -> int:
    """Return the largest number of keys that a gesture curve has within the action's place."""
    paths, place = json_properties.read(action, KEYED, list), layers.Place.of(action)
    if place is None:
        return 0
    counts = [0]
    for curve in (curve for curve in compat.curves(action) if curve.data_path in paths):
        keys = np.empty(2 * len(curve.keyframe_points), np.float32)
        curve.keyframe_points.foreach_get("co", keys)
        counts.append(int(((place.first <= keys[::2]) & (keys[::2] <= place.last)).sum()))
    return max(counts)


def convert(armature: ArmatureObject, action: bpy.types.Action, tolerance: float | None, fps: float) -> None:
    """Key the curves of an action of this package on every frame, or, within ``tolerance`` (radians), with few keys.

    Edits by hand are kept; curves that gestures do not key, and frames outside, stay unchanged."""
    paths, place = json_properties.read(action, KEYED, list), layers.Place.of(action)
    assert place is not None
    slot = layers.slot_of(armature, action)
    bag = compat.bag(action, slot)
    frames = np.arange(place.first, place.last + 1)
    held: dict[str, dict[int, np.ndarray]] = {}
    for curve in bag.fcurves:
        if curve.data_path in paths:
            values = np.array([curve.evaluate(frame) for frame in frames])
            held.setdefault(curve.data_path, {})[curve.array_index] = values
    keyed = [keyframes.Channels(dependencies.bone_of(path), path, values) for path, values in held.items()]
    stood = json_properties.read(action, _STOOD, list)
    thinner = None if tolerance is None else _thinner(armature, keyed, frames, fps, tolerance, stood)
    keyframes.write_channels(bag, keyed, frames, "LINEAR", thinner)


def _thinner(
    armature: ArmatureObject, keyed: list[keyframes.Channels], frames: np.ndarray, fps: float, tolerance: float,
    stood: Collection[str]
) -> key_reduction.KeyReducer:  # fmt: skip
    bones = reading.read(armature)
    turns = {one.bone: _rotations(armature.pose.bones[one.bone], one, len(frames)) for one in keyed if "rotation" in one.path}
    mapping, _ = reading.survey(armature)
    return key_reduction.KeyReducer(turns, limbs(bones, mapping), frames, fps, tolerance, stood)


def _rotations(bone: bpy.types.PoseBone, one: keyframes.Channels, count: int) -> np.ndarray:
    """Return the rotations (keys, 4) of a bone's channels; missing channels are at rest."""
    mode = bone.rotation_mode
    if mode in quaternion.EULER_ORDERS:
        angles = np.stack([one.values.get(index, np.zeros(count)) for index in range(3)], -1)
        return quaternion.continuous(quaternion.from_euler(angles, mode))
    columns = np.stack([one.values.get(index, np.full(count, float(index == 0))) for index in range(4)], -1)
    if mode == "QUATERNION":
        return columns
    half = 0.5 * columns[:, :1]
    axis = columns[:, 1:] / np.maximum(np.linalg.norm(columns[:, 1:], axis=-1, keepdims=True), 1e-9)
    return np.concatenate([np.cos(half), np.sin(half) * axis], -1)
