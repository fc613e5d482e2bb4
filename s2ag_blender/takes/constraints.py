"""Applies constraints exactly: keyed poses of chosen bones, and hands at objects of the scene.

The engine blends gestures with constraints on a body of standard proportions; here the character's own bones reach them
exactly. Each version of a take stores its constraints (:data:`PINS`), so that later edits keep them."""

import json
from collections.abc import Sequence
from types import TracebackType
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ...core.editing.edits import OFF
from ...core.editing.gestures import HANDS
from ...core.errors import UsageError
from ...core.motion import skeleton
from ...rigs.goals import Options
from ...rigs.skeleton import Bones, Mapping
from .. import compat, json_properties, provenance
from ..datablocks import ArmatureObject
from ..keys import curve_targets, keyframes, poses
from ..keys.apply import scene_fps
from ..rig import chosen_bones, reading
from ..translations import translate
from . import gesture_edits, stored_settings, timing

PINS = "s2ag_pins"
"""Name of an action's custom property: JSON of its constraints, each with seconds, and bones or null for all."""
MAX_POSES = 24
"""Most poses that can be kept at once."""
MAX_DISTANCE = 0.005
"""Metres by which a hand may miss its target."""
_REACH, _POINTING = 0.97, 0.93
"""Most extension of an arm, as a share of its length, to hold something and to point at it."""
_POINTED = 0.8
"""The same in the edit of an arm that points: shoulders move, and only the way is of weight."""
_ITERATIONS = 4
_SAME_SECONDS = 0.02
"""Seconds by which the times of a constraint and of its edit may differ."""


def keyed_frames(action: bpy.types.Action, bones: list[str] | None) -> list[float]:
    """Return the frames with selected keys of the bones (all, if None)."""
    start = tuple(f'pose.bones["{bpy.utils.escape_identifier(bone)}"].' for bone in bones) if bones else "pose.bones["
    curves = [curve for curve in compat.curves(action) if curve.data_path.startswith(start)]
    return sorted({point.co[0] for curve in curves for point in curve.keyframe_points if point.select_control_point})


def pose_edits(
    armature: ArmatureObject, action: bpy.types.Action, scene: bpy.types.Scene, frames: list[float], bones: list[str] | None
) -> tuple[list[dict], list[dict]]:
    """Return the edits that keep the poses on these frames, and their constraints; raises :class:`UsageError`."""
    if not frames:
        raise UsageError("No key is selected.", "Select keys of the poses that are to be kept.")
    if len(frames) > MAX_POSES:
        raise UsageError(f"Keys on {len(frames)} frames are selected.", f"Select those of at most {MAX_POSES} poses.")
    posed_as, edits, pins = resolved_figure(armature, action), [], []
    if bones:  # parents are kept, too, so that a hand stays in place
        posed = armature.pose.bones
        above = {parent.name for bone in bones for parent in posed[bone].parent_recursive}
        bones = [bone.name for bone in posed if bone.name in above.union(bones)]
    with _restored_playhead(scene):
        for frame in frames:
            scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
            at = gesture_edits.seconds_at(action, scene, frame)
            edits.append({"do": "pose", "at": at, "directions": poses.directions(armature, *posed_as).round(5).tolist()})
            pins.append({"from": at, "to": at, "bones": bones})
    return edits, pins


def place_edit(
    armature: ArmatureObject, action: bpy.types.Action, scene: bpy.types.Scene, span: tuple[int, int], hand: str,
    target: bpy.types.Object, pointing: bool
) -> tuple[list[dict], list[dict]]:  # fmt: skip
    """Return the edit that keeps a hand at an object, or pointing at it, on the frames of ``span``, and its constraint.

    Raises :class:`UsageError` if the arm cannot reach it."""
    bones, mapping, options = resolved_figure(armature, action)
    with _restored_playhead(scene):
        scene.frame_set((span[0] + span[1]) // 2)
        directions = poses.directions(armature, bones, mapping, options)
        shoulder, elbow, wrist = _arm(armature, bones, mapping, hand)
        way, reach = _reach_vector(armature, shoulder, elbow, wrist, target, pointing)
        if np.linalg.norm(way) > reach:
            remedy = "Bring it nearer to the shoulder, or let the hand point at it."
            raise UsageError("The hand cannot reach that object.", remedy)
        seen = poses.to_canonical(armature, bones, mapping, way / reach)
    upper, lower = skeleton.ARMS[HANDS.index(hand)]
    start = skeleton.to_positions(directions)[skeleton.EDGES[upper][0]]
    there = start + seen * (_POINTED if pointing else _REACH) * skeleton.LENGTHS[[upper, lower]].sum()
    first, last = (gesture_edits.seconds_at(action, scene, frame) for frame in span)
    last = max(last, first + 0.01)
    edit = {"do": "place", "from": first, "to": last, "hand": hand, "place": there.round(4).tolist()}
    pin = {"from": first, "to": last, "bones": None, "hand": hand, "object": target.name, "pointing": pointing}
    return [edit], [pin]


def pins_of(action: bpy.types.Action) -> list[dict[str, Any]]:
    """Return the constraints that an action stores."""
    kinds = {"from": int | float, "to": int | float, "bones": list | None}
    rows = json_properties.read(action, PINS, list)
    return [
        row for row in rows if isinstance(row, dict) and kinds.keys() <= row.keys() and json_properties.has_types(row, kinds)
    ]


def reapply_pins(
    former: bpy.types.Action, action: bpy.types.Action, scene: bpy.types.Scene, more: list[dict],
    others: Sequence[bpy.types.Action] = ()
) -> None:  # fmt: skip
    """Apply the constraints of the ``former`` version of a take to the new one, and ``more`` constraints on the former.

    Those whose edits are off are stored and not applied; ones that are on again are as in the first of the ``others``, versions
    of the take, that has them. Those whose edits are gone are gone."""
    pins = [*pins_of(former), *more]
    known, now = gesture_edits.edits_of(former), gesture_edits.edits_of(action)
    pins = [pin for pin in pins if pin in more or _edit_of(pin, now) or not _edit_of(pin, known)]
    if not pins:
        return
    meta, fps = provenance.require(former), scene_fps(scene)
    for pin in pins:
        if "object" in pin and pin in more or _is_off(pin, now):
            continue
        having = [one for one in (former, *others) if pin in pins_of(one) and not _is_off(pin, gesture_edits.edits_of(one))]
        source = former if pin in more or not having else having[0]
        curve_targets.lead_through(action, curve_targets.curve_values(source, _frames(meta, pin, fps), pin["bones"]), fps)
    action[PINS] = json.dumps(pins)


def _edit_of(pin: dict, edits: Sequence[dict]) -> dict | None:
    """Return the edit that a constraint belongs to, None if there is none."""
    for edit in edits:
        first, last = edit.get("from", edit.get("at")), edit.get("to", edit.get("at"))
        if edit["do"] in ("pose", "place") and max(abs(first - pin["from"]), abs(last - pin["to"])) < _SAME_SECONDS:
            return edit
    return None


def _is_off(pin: dict, edits: Sequence[dict]) -> bool:
    return bool((_edit_of(pin, edits) or {}).get(OFF))


def reach_target(armature: ArmatureObject, action: bpy.types.Action, scene: bpy.types.Scene, pin: dict) -> str:
    """Move a hand to the object of the constraint ``pin`` while ``action`` plays; return a warning if it cannot, else ""."""
    target = scene.objects.get(pin["object"])
    if target is None:
        return translate("{name} is gone, so the hand is near it only.", name=pin["object"])
    bones, mapping, _ = resolved_figure(armature, action)
    frames = _frames(provenance.require(action), pin, scene_fps(scene))
    worst = np.inf
    with _restored_playhead(scene):
        for _ in range(_ITERATIONS):
            solutions = [_solve(armature, bones, mapping, pin, target, scene, frame) for frame in frames]
            worst = max(off for off, _ in solutions)
            if worst < 0.2 * MAX_DISTANCE:
                return ""
            columns = {}
            for part in ("upper_arm", "forearm"):
                name = mapping.chains[f"{pin['hand']}_{part}"][0]
                turns = np.array([rotations[part] for _, rotations in solutions])
                one = keyframes.channels(armature.pose.bones[name], turns)
                columns |= {(one.path, index): (np.array(frames, float), column) for index, column in one.values.items()}
            curve_targets.lead_through(action, columns, scene_fps(scene))
    return "" if worst < MAX_DISTANCE else translate("The hand is {apart:.1f} cm from its place at most.", apart=100 * worst)


def _frames(meta: dict[str, Any], pin: dict[str, Any], fps: float) -> list[float]:
    """Return the scene frames of a constraint, each of which gets a key."""
    clock = timing.clock_of(meta, fps)
    first, last = (round(float(clock.frame(pin[name])), 2) for name in ("from", "to"))
    if last - first < 1:
        return [float(round(first)) if abs(first - round(first)) < 0.02 else first]
    return [float(frame) for frame in range(int(np.ceil(first - 0.02)), int(np.floor(last + 0.02)) + 1)]


def resolved_figure(armature: ArmatureObject, action: bpy.types.Action) -> tuple[Bones, Mapping, Options]:
    """Return the bones, mapping and options with which a take was keyed."""
    settings = stored_settings.settings_view(provenance.require(action)["settings"])
    bones = reading.read(armature)
    mapping = reading.resolve_mapping(armature, bones, chosen_bones.mapping_of_settings(settings))
    return bones, mapping, stored_settings.options(settings)


def _arm(armature: ArmatureObject, bones: Bones, mapping: Mapping, hand: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shoulder, elbow and wrist (3,) of the current pose in armature space."""
    posed = poses.posed_bones(armature, bones)
    heads = [posed.heads[posed.row(mapping.chains[f"{hand}_{part}"][0])] for part in ("upper_arm", "forearm")]
    return heads[0], heads[1], mapping.end(posed, f"{hand}_forearm")


def _reach_vector(
    armature: ArmatureObject, shoulder: np.ndarray, elbow: np.ndarray, wrist: np.ndarray, target: bpy.types.Object,
    pointing: bool
) -> tuple[np.ndarray, float]:  # fmt: skip
    """Return the vector (3,) from the shoulder to the wrist's goal in armature space, and the arm's reach."""
    length = float(np.linalg.norm(elbow - shoulder) + np.linalg.norm(wrist - elbow))
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    way = np.array(armature.matrix_world.inverted() @ evaluated.matrix_world.translation) - shoulder
    if pointing:
        way = way / max(np.linalg.norm(way), 1e-6) * _POINTING * length
    return way, _REACH * length


def _solve(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, pin: dict[str, Any], target: bpy.types.Object,
    scene: bpy.types.Scene, frame: float
) -> tuple[float, dict[str, np.ndarray]]:  # fmt: skip
    """Return a wrist's distance from its goal in metres at a frame, and local rotations (4,) of the arm that reach it."""
    scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
    shoulder, elbow, wrist = _arm(armature, bones, mapping, pin["hand"])
    way, reach_ = _reach_vector(armature, shoulder, elbow, wrist, target, pin["pointing"])
    size = np.linalg.norm(way)
    way = way * min(1.0, reach_ / _REACH * 0.995 / size)
    joint = _elbow(shoulder, elbow, wrist, way)
    first = _vector(elbow - shoulder).rotation_difference(_vector(joint))
    carried = np.array(first @ _vector(wrist - elbow))
    second = _vector(carried).rotation_difference(_vector(way - joint))
    # The forearm's own rotation, relative to its parent's pose before the upper arm rotates.
    own = first.inverted() @ second @ first
    turns = {"upper_arm": (first, shoulder), "forearm": (own, elbow)}
    scale = armature.matrix_world.to_scale()[0]
    off = float(np.linalg.norm(shoulder + way - wrist)) * scale
    return off, {part: _local(armature, mapping.chains[f"{pin['hand']}_{part}"][0], *turn) for part, turn in turns.items()}


def _vector(values: np.ndarray) -> Vector:
    return Vector(values.tolist())


def _elbow(shoulder: np.ndarray, elbow: np.ndarray, wrist: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return the vector from the shoulder to the elbow, in its current plane, with the wrist at ``way`` from the shoulder."""
    upper, lower, size = np.linalg.norm(elbow - shoulder), np.linalg.norm(wrist - elbow), np.linalg.norm(way)
    size = float(np.clip(size, abs(upper - lower) + 1e-4, upper + lower - 1e-5))
    along = way / max(np.linalg.norm(way), 1e-9)
    bent = elbow - shoulder
    across = bent - (bent @ along) * along
    if np.linalg.norm(across) < 1e-5:
        across = np.cross(along, [0.0, 0.0, 1.0])
    foot = (upper**2 - lower**2 + size**2) / (2 * size)
    height = np.sqrt(max(upper**2 - foot**2, 0.0))
    return foot * along + height * across / np.linalg.norm(across)


def _local(armature: ArmatureObject, name: str, turn: Quaternion, about: np.ndarray) -> np.ndarray:
    """Return a bone's local rotation (4,) after a rotation ``turn`` about a point in armature space."""
    bone, pivot = armature.pose.bones[name], _vector(about)
    matrix = Matrix.Translation(pivot) @ turn.to_matrix().to_4x4() @ Matrix.Translation(-pivot) @ bone.matrix
    local = armature.convert_space(pose_bone=bone, matrix=matrix, from_space="POSE", to_space="LOCAL")
    return np.array(local.to_quaternion())


class _restored_playhead:
    """Restores the playhead after a ``with`` block."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        self.scene = scene

    def __enter__(self) -> None:
        self.before = self.scene.frame_current, self.scene.frame_subframe

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.scene.frame_set(self.before[0], subframe=self.before[1])
