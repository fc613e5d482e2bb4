"""What an animator keyed is kept exactly: poses of chosen bones, and places of hands at objects of the scene.

The engine leads gestures into them and out of them on a body of usual proportions; here, the character's own bones get to where
they are to be. Each version of a take remembers what it keeps (:data:`PINS`), so that later edits keep it, too.
"""

import json

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ...core.direction.gestures import HANDS
from ...core.errors import UsageError
from ...core.motion import skeleton
from .. import compat, provenance, stored
from ..datablocks import ArmatureObject
from ..keys import keyframes, pinning, posing
from ..keys.apply import scene_fps
from ..rig import handpicked, reading
from ..translations import told
from . import directing, recall, timing

PINS = "s2ag_pins"
"""Name of an action's custom property that holds, as JSON text, what it keeps: seconds, and bones or null for all."""
MOST = 24
"""Poses that are kept at once."""
NEAR = 0.005
"""Metres within which a hand is at its place."""
_REACH, _POINTING = 0.97, 0.93
"""Shares of an arm's length that it is stretched by at most to hold something, and to point at it."""
_PASSES = 4


def keyed_frames(action: bpy.types.Action, bones: list[str] | None) -> list[float]:
    """Frames on which a key of the bones is selected."""
    start = tuple(f'pose.bones["{bpy.utils.escape_identifier(bone)}"].' for bone in bones) if bones else "pose.bones["
    curves = [curve for curve in compat.curves(action) if curve.data_path.startswith(start)]
    return sorted({point.co[0] for curve in curves for point in curve.keyframe_points if point.select_control_point})


def poses(
    armature: ArmatureObject,
    action: bpy.types.Action,
    scene: bpy.types.Scene,
    frames: list[float],
    bones: list[str] | None,
) -> tuple[list[dict], list[dict]]:
    """The edits that keep the poses on these frames, and what is to be remembered of them; raises :class:`UsageError`."""
    if not frames:
        raise UsageError("No key is selected.", "Select keys of the poses that are to be kept.")
    if len(frames) > MOST:
        raise UsageError(f"Keys on {len(frames)} frames are selected.", f"Select those of at most {MOST} poses.")
    posed_as, edits, pins = figure(armature, action), [], []
    if bones:  # what they hang on stays, too: a hand is where it was
        posed = armature.pose.bones
        above = {parent.name for bone in bones for parent in posed[bone].parent_recursive}
        bones = [bone.name for bone in posed if bone.name in above.union(bones)]
    with _playhead(scene):
        for frame in frames:
            scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
            at = directing.seconds(action, scene, frame)
            edits.append({"do": "pose", "at": at, "directions": posing.directions(armature, *posed_as).round(5).tolist()})
            pins.append({"from": at, "to": at, "bones": bones})
    return edits, pins


def place(
    armature: ArmatureObject,
    action: bpy.types.Action,
    scene: bpy.types.Scene,
    span: tuple[int, int],
    hand: str,
    target: np.ndarray,
    pointing: bool,
) -> tuple[list[dict], list[dict]]:
    """The edit that keeps a hand at an object, or pointing at it, from the first to the last frame of ``span``.

    Raises :class:`UsageError` where no arm reaches it.
    """
    bones, mapping, options = figure(armature, action)
    with _playhead(scene):
        scene.frame_set((span[0] + span[1]) // 2)
        directions = posing.directions(armature, bones, mapping, options)
        shoulder, elbow, wrist = _arm(armature, bones, mapping, hand)
        way, reach = _way(armature, shoulder, elbow, wrist, target, pointing)
        if np.linalg.norm(way) > reach:
            remedy = "Bring it nearer to the shoulder, or let the hand point at it."
            raise UsageError("The hand cannot reach that object.", remedy)
        seen = posing.canonical(armature, bones, mapping, way / reach)
    upper, lower = skeleton.ARMS[HANDS.index(hand)]
    start = skeleton.to_positions(directions)[skeleton.EDGES[upper][0]]
    there = start + seen * _REACH * skeleton.LENGTHS[[upper, lower]].sum()
    first, last = (directing.seconds(action, scene, frame) for frame in span)
    last = max(last, first + 0.01)
    edit = {"do": "place", "from": first, "to": last, "hand": hand, "place": there.round(4).tolist()}
    pin = {"from": first, "to": last, "bones": None, "hand": hand, "object": target.name, "pointing": pointing}
    return [edit], [pin]


def kept(action: bpy.types.Action) -> list[dict]:
    """What an action keeps."""
    kinds = {"from": int | float, "to": int | float, "bones": list | None}
    rows = stored.read(action, PINS, list)
    return [row for row in rows if isinstance(row, dict) and kinds.keys() <= row.keys() and stored.fits(row, kinds)]


def carry(former: bpy.types.Action, action: bpy.types.Action, scene: bpy.types.Scene, more: list[dict]) -> None:
    """Lead a version of a take through all that the ``former`` one keeps, and ``more`` of what that has."""
    pins = [*kept(former), *more]
    if not pins:
        return
    told_, fps = provenance.of(former), scene_fps(scene)
    for pin in pins:
        if "object" not in pin or pin not in more:
            pinning.lead(action, pinning.values(former, _frames(told_, pin, fps), pin["bones"]), fps)
    action[PINS] = json.dumps(pins)


def reach(armature: ArmatureObject, action: bpy.types.Action, scene: bpy.types.Scene, pin: dict) -> str:
    """Bring a hand of a character that plays ``action`` to its object; a warning where it does not get there."""
    target = scene.objects.get(pin["object"])
    if target is None:
        return told("{name} is gone, so the hand is near it only.", name=pin["object"])
    bones, mapping, _ = figure(armature, action)
    frames = [frame for frame in _frames(provenance.of(action), pin, scene_fps(scene))]
    worst = np.inf
    with _playhead(scene):
        for _ in range(_PASSES):
            found = [_solved(armature, bones, mapping, pin, target, scene, frame) for frame in frames]
            worst = max(off for off, _ in found)
            if worst < 0.2 * NEAR:
                return ""
            columns = {}
            for part in ("upper_arm", "forearm"):
                name = mapping.chains[f"{pin['hand']}_{part}"][0]
                turns = np.array([turned[part] for _, turned in found])
                one = keyframes.channels(armature.pose.bones[name], turns)
                columns |= {(one.path, index): (np.array(frames, float), column) for index, column in one.values.items()}
            pinning.lead(action, columns, scene_fps(scene))
    return "" if worst < NEAR else told("The hand is {apart:.1f} cm from its place at most.", apart=100 * worst)


def _frames(told_: dict, pin: dict, fps: float) -> list[float]:
    """The frames of the scene that something is kept on; there is a key on each."""
    clock = timing.clock(told_, fps)
    first, last = (round(float(clock.frame(pin[name])), 2) for name in ("from", "to"))
    if last - first < 1:
        return [float(round(first)) if abs(first - round(first)) < 0.02 else first]
    return [float(frame) for frame in range(int(np.ceil(first - 0.02)), int(np.floor(last + 0.02)) + 1)]


def figure(armature: ArmatureObject, action: bpy.types.Action) -> tuple:
    """Bones, mapping and options of a character as a take of it was laid."""
    settings = recall.view(provenance.of(action)["settings"])
    bones = reading.read(armature)
    mapping = reading.resolve_mapping(armature, bones, handpicked.chosen(settings))
    return bones, mapping, recall.options(settings)


def _arm(armature: ArmatureObject, bones, mapping, hand: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shoulder, elbow and wrist (3,) in armature space as they are now."""
    posed = posing.posed(armature, bones)
    heads = [posed.heads[posed.row(mapping.chains[f"{hand}_{part}"][0])] for part in ("upper_arm", "forearm")]
    return *heads, mapping.end(posed, f"{hand}_forearm")


def _way(armature: ArmatureObject, shoulder, elbow, wrist, target: np.ndarray, pointing: bool) -> tuple[np.ndarray, float]:
    """From the shoulder to where the wrist is to be, in armature space, and how far the arm reaches."""
    length = float(np.linalg.norm(elbow - shoulder) + np.linalg.norm(wrist - elbow))
    shown = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    way = np.array(armature.matrix_world.inverted() @ shown.matrix_world.translation) - shoulder
    if pointing:
        way = way / max(np.linalg.norm(way), 1e-6) * _POINTING * length
    return way, _REACH * length


def _solved(
    armature: ArmatureObject,
    bones,
    mapping,
    pin,
    target: np.ndarray,
    scene: bpy.types.Scene,
    frame: float,
) -> tuple[float, dict]:
    """How many metres a wrist is from its place on a frame, and how both bones are to turn, as their keys have it."""
    scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
    shoulder, elbow, wrist = _arm(armature, bones, mapping, pin["hand"])
    way, reach_ = _way(armature, shoulder, elbow, wrist, target, pin["pointing"])
    size = np.linalg.norm(way)
    way = way * min(1.0, reach_ / _REACH * 0.995 / size)
    joint = _elbow(shoulder, elbow, wrist, way)
    first = Vector(elbow - shoulder).rotation_difference(Vector(joint))
    carried = np.array(first @ Vector(wrist - elbow))
    second = Vector(carried).rotation_difference(Vector(way - joint))
    # The forearm's own turn, in the pose that its parent has before the upper arm turns.
    own = first.inverted() @ second @ first
    turns = {"upper_arm": (first, shoulder), "forearm": (own, elbow)}
    scale = armature.matrix_world.to_scale()[0]
    off = float(np.linalg.norm(shoulder + way - wrist)) * scale
    return off, {part: _local(armature, mapping.chains[f"{pin['hand']}_{part}"][0], *turn) for part, turn in turns.items()}


def _elbow(shoulder, elbow, wrist, way) -> np.ndarray:
    """From the shoulder to where the elbow is, in the plane that it is in, when the wrist is at ``way`` from the shoulder."""
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
    """The rotation (4,) that a bone has of its own when it is turned about a point in armature space."""
    bone, pivot = armature.pose.bones[name], Vector(about)
    matrix = Matrix.Translation(pivot) @ turn.to_matrix().to_4x4() @ Matrix.Translation(-pivot) @ bone.matrix
    local = armature.convert_space(pose_bone=bone, matrix=matrix, from_space="POSE", to_space="LOCAL")
    return np.array(local.to_quaternion())


class _playhead:
    """Sets the playhead back where it was."""

    def __init__(self, scene: bpy.types.Scene):
        self.scene = scene

    def __enter__(self):
        self.before = self.scene.frame_current, self.scene.frame_subframe

    def __exit__(self, *_):
        self.scene.frame_set(self.before[0], subframe=self.before[1])
