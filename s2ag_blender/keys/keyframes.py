"""Writes rotations as keyframes in bulk: one F-curve at a time, whole arrays at once."""

import contextlib
import functools
import json
from collections.abc import Callable, Collection, Generator, Iterable
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np

from ...core.motion import quaternion
from .. import compat, json_properties
from ..datablocks import ArmatureObject, Bag, Slot
from ..rig import dependencies
from ..rig.locks import apply_locks
from .curve_splitting import join, replace_between, split
from .key_reduction import KeyReducer, ReducedKeys, handles

FORMER = "s2ag_former"
"""Name of an action's custom property that holds, as JSON text, the values that its keys replaced."""
BONES_PER_SLICE = 8
"""Bones keyed per slice; a minute of keys of one bone takes 3 ms."""
_SIDES = "left", "right"
_PAIRS = ("co", "handle_left", "handle_right")
_KEY_PARTS = {
    **dict.fromkeys(_PAIRS, np.float32),
    **dict.fromkeys(("interpolation", "type", "easing", "handle_left_type", "handle_right_type"), np.int32),
    **dict.fromkeys(("back", "amplitude", "period"), np.float32),
}
"""All properties of a key, with their types."""


@dataclass(frozen=True)
class Channels:
    """Values to key for one bone: the property's data path from the object, and values (frames,) for each unlocked index."""

    bone: str
    path: str
    values: dict[int, np.ndarray]


def channels(bone: bpy.types.PoseBone, rotations: np.ndarray) -> Channels:
    """Return rotations ``(frames, 4)`` of a bone as channels in its rotation mode, without its locked channels.

    Euler angles and quaternion signs are continuous. Where a quaternion bone has single axes locked, those Euler axes stay
    at rest, as with Blender's own tools."""
    mode = bone.rotation_mode
    if mode in quaternion.EULER_ORDERS:
        values, locks, name = quaternion.to_euler(rotations, mode), bone.lock_rotation, "rotation_euler"
    else:
        locks = [bone.lock_rotation_w, *bone.lock_rotation] if bone.lock_rotations_4d else [all(bone.lock_rotation)] * 4
        if not bone.lock_rotations_4d:
            rotations = quaternion.continuous(apply_locks(bone, rotations))
        if mode == "QUATERNION":
            values, name = rotations, "rotation_quaternion"
        else:
            values, name = quaternion.to_axis_angle(rotations), "rotation_axis_angle"
    path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].{name}'
    return Channels(bone.name, path, {index: values[:, index] for index in range(values.shape[1]) if not locks[index]})


def place_channels(bone: bpy.types.PoseBone, places: np.ndarray) -> Channels:
    """Return locations ``(frames, 3)`` of a bone as channels."""
    path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].location'
    return Channels(bone.name, path, {index: places[:, index] for index in range(3)})


def write_action(
    name: str, armature: ArmatureObject, rotations: dict[str, np.ndarray], frames: np.ndarray, interpolation: str = "LINEAR",
    settings: dict[str, float] | None = None, places: dict[str, np.ndarray] | None = None
) -> Generator[None, None, tuple[bpy.types.Action, Slot | None]]:  # fmt: skip
    """Create an action (and its slot) with ``rotations`` ``{bone: (frames, 4)}`` keyed at scene ``frames`` ``(frames,)``, in
    slices; none is left if that is broken off.

    ``places`` ``{bone: (frames, 3)}`` are locations to key as well. A bone with a single rotation, and the ``settings`` by
    data path, get one constant key at the first frame. Curves are grouped by bone and keys marked as generated; nothing is
    assigned yet."""
    action, slot, bag = compat.new_action(name, armature)
    keyed = [channels(armature.pose.bones[bone], values) for bone, values in rotations.items()]
    keyed += [place_channels(armature.pose.bones[bone], values) for bone, values in (places or {}).items()]
    keyed = setting_channels(settings or {}) + keyed
    try:
        for first in range(0, len(keyed), BONES_PER_SLICE):
            write_channels(bag, keyed[first : first + BONES_PER_SLICE], frames, interpolation)
            yield
    except BaseException:
        bpy.data.actions.remove(action)
        raise
    set_range(action, frames)
    return action, slot


def setting_channels(settings: dict[str, float]) -> list[Channels]:
    """Return numbers by data path as channels with a single key each."""
    return [Channels("", path, {0: np.array([value])}) for path, value in settings.items()]


def write_channels(
    bag: Bag, keyed: list[Channels], frames: np.ndarray, interpolation: str = "LINEAR", thinner: KeyReducer | None = None,
    cut: Collection[tuple[str, int]] = ()
) -> None:  # fmt: skip
    """Write channels at scene ``frames``, replacing the keys of existing curves from the first to the last of them.

    Values of one row are keyed on the first frame only. ``thinner`` chooses which keys to keep. Curves in ``cut`` (path,
    index) keep their exact values outside the frames."""
    present = {(curve.data_path, curve.array_index): curve for curve in bag.fcurves}
    groups = {group.name: group for group in bag.groups}
    for one in keyed:
        few, dense = None, all(len(column) == len(frames) for column in one.values.values())
        if thinner is not None and one.bone and one.values and dense:
            few = thinner(one.bone, one.path, np.stack(list(one.values.values()), -1))
        for place, (index, column) in enumerate(one.values.items()):
            curve = present.get((one.path, index))
            if curve is None:
                curve = bag.fcurves.new(one.path, index=index)
                if one.bone and one.bone not in groups:
                    groups[one.bone] = bag.groups.new(one.bone)
                if one.bone:
                    curve.group = groups[one.bone]
            if few is not None:
                keys = _thin_keys(frames, column, few, place)
            else:
                style = _key_style(len(column), "CONSTANT" if len(column) < len(frames) else interpolation)
                keys = {"co": np.stack([frames[: len(column)], column], -1).astype(np.float32), **style}
            _write_keys(curve, keys, frames[-1], (one.path, index) in cut)


def set_range(action: bpy.types.Action, frames: np.ndarray) -> None:
    """Make ``frames`` the range of an action."""
    action.use_frame_range = True
    action.frame_start, action.frame_end = float(frames[0]), float(frames[-1])


def store_former_values(
    action: bpy.types.Action, armature: ArmatureObject, paths: Iterable[str] | None = None, former: dict[str, Any] | None = None
) -> None:
    """Store on ``action`` the current values of all data paths that it keys (or ``paths``); ``former`` ones take precedence."""
    current = current_values(armature, {curve.data_path for curve in compat.curves(action)} if paths is None else paths)
    stored_before = {path: value for path, value in (former or {}).items() if path in current}
    action[FORMER] = json.dumps({**current, **stored_before}, sort_keys=True)


def current_values(armature: ArmatureObject, paths: Iterable[str]) -> dict[str, Any]:
    """Return the current values at data paths of ``armature``: numbers, and lists of them."""
    resolved: dict[str, Any] = {path: armature.path_resolve(path) for path in paths}
    return {path: list(value) if hasattr(value, "__len__") else value for path, value in resolved.items()}


def former_values(action: bpy.types.Action | None) -> dict[str, Any]:
    """Return the values by data path that :func:`store_former_values` stored."""
    return json_properties.read(action, FORMER) if action is not None else {}


def restore_former_values(armature: ArmatureObject, action: bpy.types.Action, but: Collection[str] = ()) -> None:
    """Restore the values that :func:`store_former_values` stored on an action that no longer plays, except the paths ``but``.

    Paths that no longer exist, as of renamed bones, are skipped."""
    for path, value in former_values(action).items():
        if path not in but:
            with contextlib.suppress(ValueError):
                dependencies.set_value(armature, path, value)
    armature.update_tag()


def _thin_keys(frames: np.ndarray, values: np.ndarray, thin: ReducedKeys, place: int) -> dict[str, np.ndarray]:
    """Return the reduced keys of a channel (column ``place`` of ``thin``), with handles that follow its slopes."""
    at, value = frames[thin.rows].astype(float), values[thin.rows]
    left, right = handles(at, value, thin.slopes[:, place])
    style = _key_style(len(at), "BEZIER") | {"type": np.array([_number("type", kind) for kind in thin.kinds], np.int32)}
    style |= {f"handle_{side}_type": np.full(len(at), _number(f"handle_{side}_type", "ALIGNED"), np.int32) for side in _SIDES}
    places = {"co": np.stack([at, value], -1), "handle_left": left, "handle_right": right}
    return {name: points.astype(np.float32) for name, points in places.items()} | style


def _key_style(count: int, interpolation: str) -> dict[str, np.ndarray]:
    """Return the properties that are equal for all keys, as arrays."""
    chosen = {"interpolation": interpolation, "type": "GENERATED"}
    if interpolation == "BEZIER":
        chosen |= {"handle_left_type": "AUTO_CLAMPED", "handle_right_type": "AUTO_CLAMPED"}
    return {key: np.full(count, _number(key, value), np.int32) for key, value in chosen.items()}


@functools.cache
def _number(key: str, value: str) -> int:
    """Return the number of an enum item of a key's property, as ``foreach_set`` takes it."""
    return cast(bpy.types.EnumProperty, bpy.types.Keyframe.bl_rna.properties[key]).enum_items[value].value


def _write_keys(curve: bpy.types.FCurve, made: dict[str, np.ndarray], last: float, cut: bool = False) -> None:
    """Write keys to a curve in place of those from the first of ``made`` to ``last``."""
    points = curve.keyframe_points
    if len(points):
        made = _merge(points, made, last, cut)
    replace_keys(curve, made)


def columns(points: bpy.types.FCurveKeyframePoints) -> dict[str, np.ndarray]:
    """Return all properties of a curve's keys, as arrays."""
    kept = {}
    for key, kind in _KEY_PARTS.items():
        width = 2 if key in _PAIRS else 1
        column = np.empty(len(points) * width, kind)
        points.foreach_get(key, column)
        kept[key] = column.reshape(-1, 2) if width == 2 else column
    return kept


def replace_keys(curve: bpy.types.FCurve, made: dict[str, np.ndarray]) -> None:
    """Replace all keys of a curve by arrays like those of :func:`columns`."""
    points = curve.keyframe_points
    points.clear()
    points.add(len(made["co"]))
    for key, column in made.items():
        points.foreach_set(key, column.ravel())
    curve.update()


def move_keys(curve: bpy.types.FCurve, where: Callable[[np.ndarray], np.ndarray]) -> None:
    """Move the keys of a curve, and their handles, to the frames that ``where`` returns for their frames."""
    keys = columns(curve.keyframe_points)
    for name in _PAIRS:
        keys[name][:, 0] = where(keys[name][:, 0].astype(float)).astype(np.float32)
    replace_keys(curve, keys)


def trim_curve(curve: bpy.types.FCurve, first: float, last: float) -> None:
    """Trim a curve to the frames from ``first`` to ``last``, where its shape stays the same."""
    keys = columns(curve.keyframe_points)
    if len(keys["co"]) and keys["co"][0, 0] < first:
        keys = join(*split(keys, first, _codes())[1:])
    if len(keys["co"]) > 1 and keys["co"][-1, 0] > last:
        keys = join(*split(keys, last, _codes())[:2])
    replace_keys(curve, keys)


def _codes() -> dict[str, int]:
    codes = {name: _number("interpolation", name) for name in ("CONSTANT", "LINEAR", "BEZIER")}
    return codes | {"FREE": _number("handle_left_type", "FREE")}


def _merge(
    points: bpy.types.FCurveKeyframePoints, made: dict[str, np.ndarray], last: float, cut: bool
) -> dict[str, np.ndarray]:
    """Return the keys of a curve with ``made`` in place of those from the first of ``made`` to ``last``."""
    kept = columns(points)
    filled = {key: made.get(key, _default(key, kind, made["co"])) for key, kind in _KEY_PARTS.items()}
    if cut:
        return replace_between(kept, filled, last, _codes())
    at = kept["co"][:, 0]
    before, after = at < made["co"][0, 0], at > last
    return {key: np.concatenate([kept[key][before], filled[key], kept[key][after]]) for key in _KEY_PARTS}


def _default(key: str, kind: type, at: np.ndarray) -> np.ndarray:
    if key in _PAIRS:
        return at
    """Return the default of a key's property for the keys at ``at`` (n, 2)."""
    definition: Any = bpy.types.Keyframe.bl_rna.properties[key]
    value = _number(key, definition.default) if definition.type == "ENUM" else definition.default
    return np.full(len(at), value, kind)
