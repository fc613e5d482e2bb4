"""Rotations to keyframes in bulk: a new action, one curve at a time, whole arrays at once."""

import contextlib
import functools
import json
from collections.abc import Callable, Collection
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.motion import quaternion
from .. import compat, stored
from ..datablocks import ArmatureObject
from ..rig import dependencies
from ..rig.locks import held
from .cutting import around, joined, split
from .thinning import Thin, Thinner, handles

FORMER = "s2ag_former"
"""Name of an action's custom property that holds, as JSON text, what its keys replaced."""


_SIDES = "left", "right"
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


def place_channels(bone: bpy.types.PoseBone, places: np.ndarray) -> Channels:
    """Locations ``(frames, 3)`` of a bone."""
    path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].location'
    return Channels(bone.name, path, {index: places[:, index] for index in range(3)})


def write_action(
    name: str,
    armature: ArmatureObject,
    rotations: dict[str, np.ndarray],
    frames: np.ndarray,
    interpolation: str = "LINEAR",
    settings: dict[str, float] | None = None,
    places: dict[str, np.ndarray] | None = None,
) -> tuple[bpy.types.Action, object]:
    """A new action (and its slot) with ``rotations`` ``{bone: (frames, 4)}`` keyed at scene ``frames`` ``(frames,)``.

    ``places`` ``{bone: (frames, 3)}`` are locations besides.

    A bone with a single rotation, and the ``settings`` by data path, get one constant key at the first frame. Curves are
    grouped by bone and marked as generated; nothing is assigned yet.
    """
    action, slot, bag = compat.new_action(name, armature)
    keyed = [channels(armature.pose.bones[bone], values) for bone, values in rotations.items()]
    keyed += [place_channels(armature.pose.bones[bone], values) for bone, values in (places or {}).items()]
    write_channels(bag, setting_channels(settings or {}) + keyed, frames, interpolation)
    set_range(action, frames)
    return action, slot


def setting_channels(settings: dict[str, float]) -> list[Channels]:
    """Numbers by data path as channels with a single key each."""
    return [Channels("", path, {0: np.array([value])}) for path, value in settings.items()]


def write_channels(
    bag,
    keyed: list[Channels],
    frames: np.ndarray,
    interpolation: str = "LINEAR",
    thinner: Thinner | None = None,
    cut: Collection[tuple[str, int]] = (),
) -> None:
    """Key ``keyed`` at scene ``frames``; where a curve is there already, its keys from the first to the last of them go.

    Values of one row are keyed on the first frame only. ``thinner`` says which keys are enough. Curves of ``cut`` (path and
    index) keep their values outside the frames exactly.
    """
    present = {(curve.data_path, curve.array_index): curve for curve in bag.fcurves}
    groups = {group.name: group for group in bag.groups}
    for one in keyed:
        whole = thinner is not None and one.bone and all(len(column) == len(frames) for column in one.values.values())
        few = thinner(one.bone, one.path, np.stack(list(one.values.values()), -1)) if whole and one.values else None
        for place, (index, column) in enumerate(one.values.items()):
            curve = present.get((one.path, index))
            if curve is None:
                curve = bag.fcurves.new(one.path, index=index)
                if one.bone and one.bone not in groups:
                    groups[one.bone] = bag.groups.new(one.bone)
                if one.bone:
                    curve.group = groups[one.bone]
            if few is not None:
                made = _few(frames, column, few, place)
            else:
                still = len(column) < len(frames)
                made = _all(frames[: len(column)], column, "CONSTANT" if still else interpolation)
            _fill(curve, made, frames[-1], (one.path, index) in cut)


def set_range(action: bpy.types.Action, frames: np.ndarray) -> None:
    """Make ``frames`` the range of an action."""
    action.use_frame_range = True
    action.frame_start, action.frame_end = float(frames[0]), float(frames[-1])


def remember(action: bpy.types.Action, armature: ArmatureObject, paths=None, former: dict | None = None) -> None:
    """Store what ``armature`` has now of all that ``action`` keys, or of ``paths``; values of ``former`` go before that."""
    plain = values(armature, {curve.data_path for curve in compat.curves(action)} if paths is None else paths)
    known = {path: value for path, value in (former or {}).items() if path in plain}
    action[FORMER] = json.dumps({**plain, **known}, sort_keys=True)


def values(armature: ArmatureObject, paths) -> dict:
    """What is at data paths of ``armature`` now: numbers, and lists of them."""
    found = {path: armature.path_resolve(path) for path in paths}
    return {path: list(value) if hasattr(value, "__len__") else value for path, value in found.items()}


def former(action: bpy.types.Action | None) -> dict:
    """What :func:`remember` stored: values by data path."""
    return stored.read(action, FORMER) if action is not None else {}


def give_back(armature: ArmatureObject, action: bpy.types.Action, but: Collection[str] = ()) -> None:
    """Set everything on ``armature`` but ``but`` to what :func:`remember` stored on an action that no longer plays.

    What is no longer there, as a bone that was renamed, is passed over.
    """
    for path, value in former(action).items():
        if path not in but:
            with contextlib.suppress(ValueError):
                dependencies.set_value(armature, path, value)
    armature.update_tag()


def _all(frames: np.ndarray, values: np.ndarray, interpolation: str) -> dict[str, np.ndarray]:
    """A key for every value."""
    return {"co": np.stack([frames, values], -1).astype(np.float32), **_key_style(len(frames), interpolation)}


def _few(frames: np.ndarray, values: np.ndarray, thin: Thin, place: int) -> dict[str, np.ndarray]:
    """The keys that are left of a channel, with the handles that make up for the others."""
    at, value = frames[thin.rows].astype(float), values[thin.rows]
    left, right = handles(at, value, thin.slopes[:, place])
    style = _key_style(len(at), "BEZIER") | {"type": np.array([_number("type", kind) for kind in thin.kinds], np.int32)}
    style |= {f"handle_{side}_type": np.full(len(at), _number(f"handle_{side}_type", "ALIGNED"), np.int32) for side in _SIDES}
    places = {"co": np.stack([at, value], -1), "handle_left": left, "handle_right": right}
    return {name: points.astype(np.float32) for name, points in places.items()} | style


def _key_style(count: int, interpolation: str) -> dict[str, np.ndarray]:
    """Key properties that hold for every key, as arrays that Blender takes in one go."""
    chosen = {"interpolation": interpolation, "type": "GENERATED"}
    if interpolation == "BEZIER":
        chosen |= {"handle_left_type": "AUTO_CLAMPED", "handle_right_type": "AUTO_CLAMPED"}
    return {key: np.full(count, _number(key, value), np.int32) for key, value in chosen.items()}


@functools.cache
def _number(key: str, value: str) -> int:
    return bpy.types.Keyframe.bl_rna.properties[key].enum_items[value].value


def _fill(curve: bpy.types.FCurve, made: dict[str, np.ndarray], last: float, cut: bool = False) -> None:
    points = curve.keyframe_points
    if len(points):
        made = _merged(points, made, last, cut)
    replace(curve, made)


def columns(points: np.ndarray) -> dict[str, np.ndarray]:
    """All that the keys of a curve are, as arrays."""
    kept = {}
    for key, kind in _KEY_PARTS.items():
        width = 2 if key in _PAIRS else 1
        column = np.empty(len(points) * width, kind)
        points.foreach_get(key, column)
        kept[key] = column.reshape(-1, 2) if width == 2 else column
    return kept


def replace(curve: bpy.types.FCurve, made: dict[str, np.ndarray]) -> None:
    """Give a curve the keys of arrays like those of :func:`columns` instead of its own."""
    points = curve.keyframe_points
    points.clear()
    points.add(len(made["co"]))
    for key, column in made.items():
        points.foreach_set(key, column.ravel())
    curve.update()


def moved(curve: bpy.types.FCurve, where: Callable[[np.ndarray], np.ndarray]) -> None:
    """Put the keys of a curve, and their handles, to the frames that ``where`` gives for theirs."""
    keys = columns(curve.keyframe_points)
    for name in _PAIRS:
        keys[name][:, 0] = where(keys[name][:, 0].astype(float)).astype(np.float32)
    replace(curve, keys)


def cut(curve: bpy.types.FCurve, first: float, last: float) -> None:
    """Leave a curve only what it has from the first to the last of these frames, where it stays as it is."""
    keys = columns(curve.keyframe_points)
    if len(keys["co"]) and keys["co"][0, 0] < first:
        keys = joined(*split(keys, first, _codes())[1:])
    if len(keys["co"]) > 1 and keys["co"][-1, 0] > last:
        keys = joined(*split(keys, last, _codes())[:2])
    replace(curve, keys)


def _codes() -> dict[str, int]:
    codes = {name: _number("interpolation", name) for name in ("CONSTANT", "LINEAR", "BEZIER")}
    return codes | {"FREE": _number("handle_left_type", "FREE")}


def _merged(points: np.ndarray, made: dict[str, np.ndarray], last: float, cut: bool) -> dict[str, np.ndarray]:
    """The keys that are there, without those from the first of ``made`` to ``last``, and ``made`` in their place."""
    kept = columns(points)
    filled = {key: made.get(key, _default(key, kind, made["co"])) for key, kind in _KEY_PARTS.items()}
    if cut:
        return around(kept, filled, last, _codes())
    at = kept["co"][:, 0]
    before, after = at < made["co"][0, 0], at > last
    return {key: np.concatenate([kept[key][before], filled[key], kept[key][after]]) for key in _KEY_PARTS}


def _default(key: str, kind: type, at: np.ndarray) -> np.ndarray:
    if key in _PAIRS:
        return at
    standing = bpy.types.Keyframe.bl_rna.properties[key]
    value = _number(key, standing.default) if standing.type == "ENUM" else standing.default
    return np.full(len(at), value, kind)
