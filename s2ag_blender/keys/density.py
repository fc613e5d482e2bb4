"""An action of ours with a key on every frame, or with those alone that matter, as the animator likes it."""

import json
from collections.abc import Collection

import bpy
import numpy as np

from ...core.motion import quaternion
from ...rigs.plain import Bones, Mapping
from .. import compat, stored
from ..datablocks import ArmatureObject
from ..rig import dependencies, reading
from . import keyframes, layers, thinning

KEYED = "s2ag_keyed"
"""Name of an action's custom property that holds, as JSON text, the data paths that gestures keyed."""

_STOOD = "s2ag_stood"


def note(action: bpy.types.Action, keyed: list[keyframes.Channels], stood: Collection[str] = ()) -> None:
    """Remember on an action what gestures key on every frame, and which bones ``stood`` keep feet in place."""
    action[KEYED] = json.dumps(sorted(one.path for one in keyed if one.bone))
    action[_STOOD] = json.dumps(sorted(stood))


def limbs(bones: Bones, mapping: Mapping) -> dict[str, str]:
    """Which limb each bone moves with: ``left`` or ``right`` for arms and what hangs on them, "" for all else."""
    found = {}
    for side in ("left", "right"):
        arm = {name for part, chain in mapping.chains.items() if part.startswith(side) for name in chain}
        for row, name in enumerate(bones.names):
            if name in arm or found.get(bones.names[bones.parents[row]] if bones.parents[row] >= 0 else "") == side:
                found[name] = side
    return found


def is_dense(action: bpy.types.Action) -> bool:
    """Whether gestures are keyed on every frame; not where nothing is known of them."""
    place = layers.Place.of(action)
    return place is not None and most_keys(action) >= place.last - place.first


def most_keys(action: bpy.types.Action) -> int:
    """How many keys of gestures the curve has that has most."""
    paths, place = stored.read(action, KEYED, list), layers.Place.of(action)
    counts = [0]
    for curve in (curve for curve in compat.curves(action) if curve.data_path in paths):
        keys = np.empty(2 * len(curve.keyframe_points), np.float32)
        curve.keyframe_points.foreach_get("co", keys)
        counts.append(int(((place.first <= keys[::2]) & (keys[::2] <= place.last)).sum()))
    return max(counts)


def convert(armature: ArmatureObject, action: bpy.types.Action, tolerance: float | None, fps: float) -> None:
    """Key what an action of ours shows on every frame, or, within ``tolerance`` (radians), on those that matter.

    What was edited by hand since stays; curves that gestures do not key, and frames outside, are left alone.
    """
    paths, place = stored.read(action, KEYED, list), layers.Place.of(action)
    slot = layers.slot_of(armature, action)
    bag = compat.bag(action, slot)
    frames = np.arange(place.first, place.last + 1)
    held: dict[str, dict[int, np.ndarray]] = {}
    for curve in bag.fcurves:
        if curve.data_path in paths:
            values = np.array([curve.evaluate(frame) for frame in frames])
            held.setdefault(curve.data_path, {})[curve.array_index] = values
    keyed = [keyframes.Channels(dependencies.bone_of(path), path, values) for path, values in held.items()]
    stood = stored.read(action, _STOOD, list)
    thinner = None if tolerance is None else _thinner(armature, keyed, frames, fps, tolerance, stood)
    keyframes.write_channels(bag, keyed, frames, "LINEAR", thinner)


def _thinner(
    armature: ArmatureObject,
    keyed: list[keyframes.Channels],
    frames: np.ndarray,
    fps: float,
    tolerance: float,
    stood,
) -> thinning.Thinner:
    bones = reading.read(armature)
    turns = {one.bone: _rotations(armature.pose.bones[one.bone], one, len(frames)) for one in keyed if "rotation" in one.path}
    found, _ = reading.survey(armature)
    return thinning.Thinner(turns, limbs(bones, found), frames, fps, tolerance, stood)


def _rotations(bone: bpy.types.PoseBone, one: keyframes.Channels, count: int) -> np.ndarray:
    """Rotations (keys, 4) that channels of a bone make; what has no channel is none."""
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
