"""Rotations to keyframes in bulk: a new action, one curve at a time, whole arrays at once."""

import functools
import json
from dataclasses import dataclass

import bpy
import numpy as np

from ...rigs import quaternion
from .. import compat
from ..rig import dependencies
from ..rig.locks import held

FORMER = "s2ag_former"
"""Name of an action's custom property that holds, as JSON text, what its keys replaced."""


_PAIRS = ("co", "handle_left", "handle_right")
_KEY_PARTS = {
    **dict.fromkeys(_PAIRS, np.float32),
    **dict.fromkeys(("interpolation", "type", "easing", "handle_left_type", "handle_right_type"), np.int32),
    **dict.fromkeys(("back", "amplitude", "period"), np.float32),
}
"""Everything that makes up a key."""


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
    keyed = [channels(armature.pose.bones[bone], values) for bone, values in rotations.items()]
    write_channels(bag, setting_channels(settings or {}) + keyed, frames, interpolation)
    set_range(action, frames)
    return action, slot


def setting_channels(settings: dict[str, float]) -> list[Channels]:
    """Numbers by data path as channels with a single key each."""
    return [Channels("", path, {0: np.array([value])}) for path, value in settings.items()]


def write_channels(bag, keyed: list[Channels], frames: np.ndarray, interpolation: str = "LINEAR") -> None:
    """Key ``keyed`` at scene ``frames``; where a curve is there already, its keys from the first to the last of them go.

    Values of one row are keyed on the first frame only.
    """
    present = {(curve.data_path, curve.array_index): curve for curve in bag.fcurves}
    groups = {group.name: group for group in bag.groups}
    for one in keyed:
        for index, column in one.values.items():
            curve = present.get((one.path, index))
            if curve is None:
                curve = bag.fcurves.new(one.path, index=index)
                if one.bone and one.bone not in groups:
                    groups[one.bone] = bag.groups.new(one.bone)
                if one.bone:
                    curve.group = groups[one.bone]
            still = len(column) < len(frames)
            _fill(curve, frames[: len(column)], column, "CONSTANT" if still else interpolation, frames[-1])


def set_range(action: bpy.types.Action, frames: np.ndarray) -> None:
    """Make ``frames`` the range of an action."""
    action.use_frame_range = True
    action.frame_start, action.frame_end = float(frames[0]), float(frames[-1])


def remember(action: bpy.types.Action, armature: bpy.types.Object, paths=None, former: dict | None = None) -> None:
    """Store what ``armature`` has now of all that ``action`` keys, or of ``paths``; values of ``former`` go before that."""
    paths = {curve.data_path for curve in compat.curves(action)} if paths is None else paths
    values = {path: armature.path_resolve(path) for path in paths}
    plain = {path: list(value) if hasattr(value, "__len__") else value for path, value in values.items()}
    known = {path: value for path, value in (former or {}).items() if path in plain}
    action[FORMER] = json.dumps({**plain, **known}, sort_keys=True)


def former(action: bpy.types.Action | None) -> dict:
    """What :func:`remember` stored: values by data path."""
    return json.loads(action.get(FORMER, "{}")) if action is not None else {}


def give_back(armature: bpy.types.Object, action: bpy.types.Action, but=()) -> None:
    """Set everything on ``armature`` to what :func:`remember` stored on an action that no longer plays, ``but`` these paths."""
    for path, value in former(action).items():
        if path not in but:
            dependencies.set_value(armature, path, value)
    armature.update_tag()


def _key_style(count: int, interpolation: str) -> dict[str, np.ndarray]:
    """Key properties that hold for every key, as arrays that Blender takes in one go."""
    chosen = {"interpolation": interpolation, "type": "GENERATED"}
    if interpolation == "BEZIER":
        chosen |= {"handle_left_type": "AUTO_CLAMPED", "handle_right_type": "AUTO_CLAMPED"}
    return {key: np.full(count, _number(key, value), np.int32) for key, value in chosen.items()}


@functools.cache
def _number(key: str, value: str) -> int:
    return bpy.types.Keyframe.bl_rna.properties[key].enum_items[value].value


def _fill(curve: bpy.types.FCurve, frames: np.ndarray, values: np.ndarray, interpolation: str, last: float) -> None:
    points = curve.keyframe_points
    made = {"co": np.stack([frames, values], -1).astype(np.float32), **_key_style(len(frames), interpolation)}
    if len(points):
        made = _merged(points, made, last)
        points.clear()
    points.add(len(made["co"]))
    for key, column in made.items():
        points.foreach_set(key, column.ravel())
    curve.update()


def _merged(points, made: dict[str, np.ndarray], last: float) -> dict[str, np.ndarray]:
    """The keys that are there, without those from the first of ``made`` to ``last``, and ``made`` in their place."""
    kept = {}
    for key, kind in _KEY_PARTS.items():
        width = 2 if key in _PAIRS else 1
        column = np.empty(len(points) * width, kind)
        points.foreach_get(key, column)
        kept[key] = column.reshape(-1, 2) if width == 2 else column
    at = kept["co"][:, 0]
    before, after = at < made["co"][0, 0], at > last
    filled = {key: made.get(key, _default(key, kind, made["co"])) for key, kind in _KEY_PARTS.items()}
    return {key: np.concatenate([kept[key][before], filled[key], kept[key][after]]) for key in _KEY_PARTS}


def _default(key: str, kind: type, at: np.ndarray) -> np.ndarray:
    if key in _PAIRS:
        return at
    standing = bpy.types.Keyframe.bl_rna.properties[key]
    value = _number(key, standing.default) if standing.type == "ENUM" else standing.default
    return np.full(len(at), value, kind)
