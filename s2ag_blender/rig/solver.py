"""Solves a motion on any rig: in closed form for plain skeletons, by measuring where constraints or drivers act."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...core.motion import quaternion
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import retarget, seat
from ...rigs.goals import Goals, Options
from ...rigs.proportions import TrunkShape
from ...rigs.skeleton import ARMS, Bones, Mapping, character_frame
from ..datablocks import ArmatureObject
from . import controls, dependencies, hands, weight_shift
from .controls import Take

_TRANSFORMS = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")
_FEET_SLIP = "The feet of this control rig do not stay when its hips move, so the weight does not shift."


@dataclass(frozen=True)
class Solution:
    """``rotations`` ``{bone: (keys, 4)}``, and ``values`` (by data path) that the rig needs to follow them.

    ``why`` says in words why bones had to be measured; "" where the closed form held. ``places`` ``{bone: (keys, 3)}`` are
    locations of the pelvis where the weight shifts, ``stood`` are the pelvis and the bones of the legs."""

    rotations: dict[str, np.ndarray]
    values: dict[str, float]
    why: str = ""
    places: dict[str, np.ndarray] = field(default_factory=dict)
    stood: tuple[str, ...] = ()


def solve_in_slices(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, motion: Take, keys: Take, *, scene: bpy.types.Scene,
    options: Options | None = None, tell: Callable[[str], None], trunk: TrunkShape | None
) -> Generator[None, None, Solution]:  # fmt: skip
    """Solve the rotations of the mapped bones at ``keys``, by the solver that the rig needs; a generator that works in slices.

    For a plain rig only the first slice reads from Blender. ``motion`` and ``keys`` are the same motion, at its own frames
    and at those to be keyed; hands and arms stay out of the ``trunk`` (estimated, if None), and rest on the thighs
    of who sits. Sentences about bones that cannot reach their goals go to ``tell``. Nothing in the file changes. Raises
    :class:`RigUnusable` for an unusable mapping."""
    values = switches(armature, mapping, tell)
    why = why_not_plain(armature, bones, mapping, values)
    seated = find_seat(armature, bones, mapping, options or Options(), trunk)
    moving = motion.hands is not None or seated is not None
    free = hands.free_bones(armature, posed=moving)

    frame = character_frame(bones, mapping.check(bones))
    legs, places, obstacle = None, {}, ""
    if keys.pelvis is not None and seated is None:
        legs, obstacle = (None, _FEET_SLIP) if why else weight_shift.find_legs(armature, bones, mapping, frame[2])
        if legs is None and (why or dependencies.ik_constraints(armature)):
            places = weight_shift.hip_locations(armature, bones, mapping, frame, keys.pelvis, scene=scene, values=values)
        if legs is None and not places:
            tell(obstacle)

    def ask(rest: Bones, take: Take, **about: Any) -> Goals:
        about |= {"girth": trunk, "free": free, "frame": frame, "hands": take.hands, "pelvis": take.pelvis, "legs": legs}
        about["seated"] = seated
        return Goals(rest, mapping, take.directions, take.fps, options, **about)

    yield
    goals = ask(bones, keys, clear=False)
    followers = hands.free_bones(armature, ruled=True, posed=moving) if why else free
    for sentence in hands.obstacles(goals, free, followers) if moving else ():
        tell(sentence)
    yield
    yield from goals.clearing()
    yield
    if why:
        about = {"scene": scene, "ask": ask, "values": values, "hands": followers, "tell": tell}
        rotations = yield from controls.solve_in_slices(armature, bones, mapping, motion, keys, **about)
    else:
        rotations = yield from retarget.rotations_in_slices(goals)
    yield
    palms = hands.posed_palms(armature, goals, free) if moving else ()
    rotations = {name: quaternion.IDENTITY[None] for name in palms} | goals.extras() | rotations
    if goals.stood is None:
        return Solution(rotations, values, why, places, tuple(places))
    return Solution(rotations, values, why, goals.stood.places, tuple(bones.names[row] for row in goals.stood.turned))


def find_seat(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, options: Options, trunk: TrunkShape | None
) -> seat.Seat | None:
    """Return the seat of a character by its pose of the current frame (:func:`seat.find`), or None if it does not sit."""
    posed = np.array([armature.pose.bones[name].matrix for name in bones.names], float)
    above = np.array(armature.matrix_world[2])
    size = float(np.linalg.norm(above[:3]))
    table = (options.table - above[3]) / size if options.table > 0 else None
    return seat.find(bones, mapping, posed, above[:3] / size, options.seated, table, trunk)


def switches(armature: ArmatureObject, mapping: Mapping, tell: Callable[[str], None]) -> dict[str, float]:
    """Return the property values that make the rig follow its mapped bones, by data path from the object.

    A sentence for each switch that is missing or driven goes to ``tell``."""
    result, driven = {}, {curve.data_path for curve in dependencies.drivers(armature)}
    for switch in mapping.switches:
        path = f'pose.bones["{bpy.utils.escape_identifier(switch.bone)}"]'
        path += switch.path if switch.path.startswith("[") else f".{switch.path}"
        try:
            armature.path_resolve(path)
        except ValueError:
            tell(f'Bone "{switch.bone}" has no {switch.path}: the rig may not follow its arms.')
            continue
        if path in driven:
            tell(f'A driver rules {switch.path} of bone "{switch.bone}": the rig may not follow its arms.')
        else:
            result[path] = switch.value
    return result


def why_not_plain(armature: ArmatureObject, bones: Bones, mapping: Mapping, values: dict[str, float] | None = None) -> str:
    """Return why the closed form for plain skeletons does not hold for a rig, in words; "" where it does.

    ``values`` are property values that will be set, by data path from the object."""
    moved = [name for part in EDGE_NAMES for name in mapping.chains.get(part, ()) if name not in mapping.held]
    marks = [tip for part in mapping.chains if (tip := mapping.tip(part))]
    rows = {bones.row(name) for name in (*moved, *marks)}
    lineage = {bones.names[row] for own in rows for row in (own, *bones.ancestors(own))}
    for row in sorted(bones.row(name) for name in lineage):
        if bones.parents[row] >= 0 and not bones.inherits[row]:
            return f'bone "{bones.names[row]}" does not turn with its parent'
    for part in ARMS:
        tip = mapping.tip(part)
        if tip and bones.row(mapping.chains[part][-1]) not in bones.ancestors(bones.row(tip)):
            return f'bone "{tip}" does not hang on "{mapping.chains[part][-1]}"'
    for name in moved:
        if any(armature.pose.bones[name].lock_rotation):
            return f'part of the rotation of bone "{name}" is locked'
    return _constrained(armature, lineage, values or {}) or _driven(armature, lineage)


def _constrained(armature: ArmatureObject, lineage: set[str], values: dict[str, float]) -> str:
    """Return which constraint acts on one of the bones ``lineage``, in words; "" if none does."""
    driven = {curve.data_path for curve in dependencies.drivers(armature)}

    def acts(constraint: bpy.types.Constraint) -> bool:
        path = constraint.path_from_id("influence")
        return path in driven or (not constraint.mute and values.get(path, constraint.influence) > 0)

    for name in sorted(lineage):
        for constraint in armature.pose.bones[name].constraints:
            if acts(constraint):
                return f'bone "{name}" has the constraint "{constraint.name}"'
    for name, pullers in dependencies.ik_constraints(armature).items():
        for bone, constraint in pullers:
            if name in lineage and acts(constraint):
                return f'the constraint "{constraint.name}" of bone "{bone.name}" turns bone "{name}"'
    return ""


def _driven(armature: ArmatureObject, lineage: set[str]) -> str:
    """Return which driver acts on a transform of one of the bones ``lineage``, in words; "" if none does."""
    for curve in dependencies.drivers(armature):
        name, setting = dependencies.bone_of(curve.data_path), curve.data_path.rpartition(".")[2]
        if name in lineage and setting in _TRANSFORMS:
            return f'a driver rules {setting} of bone "{name}"'
    return ""
