"""Finds the bones beyond the mapped ones that may be keyed without overwriting the user's work: hands, fingers, twist bones.

What a user wants to stay as it is, is keyed, locked, or ruled by a constraint or a driver. A pose without keys is no such
wish for hands: importers leave one on most bones, and it tells nothing about who made it."""

from collections.abc import Collection, Iterator

import bpy
import numpy as np

from ...rigs import fingers
from ...rigs.goals import Goals
from .. import compat, provenance
from ..datablocks import ArmatureObject
from . import dependencies

_AT_REST = 1e-4
"""A rotation counts as rest up to this difference (radians, or units of its channels)."""


def free_bones(armature: ArmatureObject, ruled: bool = False, posed: bool = False, among: Collection[str] = ()) -> set[str]:
    """Return the names of bones (of ``among``, if any) that only this package's actions turn, at rest or as they left them.

    Excludes bones that other actions key, that are locked, or that have an active constraint or a driver; ``ruled``
    includes those with constraints and drivers, ``posed`` those that have a pose without keys."""
    ours, theirs = keyed_bones(armature)
    if not ruled:
        theirs |= {dependencies.bone_of(curve.data_path) for curve in dependencies.drivers(armature)}
        theirs |= set(dependencies.ik_constraints(armature))
    bones = {
        bone.name: posed or bone.name in ours or _rests(bone)
        for bone in armature.pose.bones
        if (not among or bone.name in among)
        and bone.name not in theirs
        and not any(bone.lock_rotation)
        and (ruled or not any(constraint.influence > 0 and not constraint.mute for constraint in bone.constraints))
    }
    return {name for name, free in bones.items() if free} | posed_by_former_actions(
        armature, [name for name in bones if not bones[name]]
    )


def posed_palms(armature: ArmatureObject, goals: Goals, free: Collection[str]) -> set[str]:
    """Return the free bones between hands and fingers that have a pose: the fingers of a motion start from rest."""
    found, bones = set(), goals.bones
    for hand in filter(None, (goals.hand(side).fingers for side in fingers.SIDES)):
        above = {row for chain in (*hand.fingers, hand.thumb) for row in (bones.ancestors(chain[0]) if chain else ())}
        found |= {bones.names[row] for row in above if hand.row in bones.ancestors(row)}
    return {name for name in found if name in free and not _rests(armature.pose.bones[name])}


def obstacles(goals: Goals, free: Collection[str], wrists: Collection[str]) -> Iterator[str]:
    """Yield a sentence for what keeps hands and fingers from their motion: only bones in ``wrists`` and ``free`` may turn."""
    bones, chains, fingerless = goals.bones, goals.mapping.chains, []
    for side in fingers.SIDES:
        chain, hand = chains.get(f"{side}_hand", ()), goals.hand(side).fingers
        if not chain:
            yield "An arm has no bone for its hand, so this hand does not move."
            continue
        if chain[0] not in wrists:
            yield f'Bone "{chain[0]}" is keyed, locked or held by a constraint, so its hand follows the forearm.'
        rows = [row for finger in (*hand.fingers, hand.thumb) for row in finger[:3]] if hand is not None else []
        if rows and not any(bones.names[row] in free for row in rows):
            name = bones.names[rows[0]]
            yield f'Bone "{name}" and others are keyed, locked or held by constraints, so its fingers do not move.'
        fingerless += [] if rows else [side]
    if len(fingerless) == len(fingers.SIDES):
        yield "No fingers were found below the hands, so each hand moves as a whole."


def posed_by_former_actions(armature: ArmatureObject, names: list[str], what: str = "rotation") -> set[str]:
    """Return those of ``names`` whose current rotation (or location) equals a frame of an action of this package.

    Blender keeps the last pose when an action is removed; such a pose is no work of the user."""
    bones = set()
    for action in bpy.data.actions if names else ():
        if provenance.read(action) is None:
            continue
        curves, (first, last) = {}, action.frame_range
        for curve in compat.curves(action):
            curves.setdefault(curve.data_path, []).append(curve)
        frames = np.arange(np.floor(first), np.ceil(last) + 1)
        remaining = [name for name in names if name not in bones]
        bones |= {name for name in remaining if _matches_curves(armature.pose.bones[name], what, curves, frames)}
    return bones


def _matches_curves(bone: bpy.types.PoseBone, what: str, curves: dict[str, list[bpy.types.FCurve]], frames: np.ndarray) -> bool:
    """Return whether the F-curves ``{data path: curves}`` evaluate to a bone's current values at one of the ``frames``."""
    kinds = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
    name = kinds.get(bone.rotation_mode, "rotation_euler") if what == "rotation" else what
    own, now = curves.get(bone.path_from_id(name), ()), getattr(bone, name)
    for curve in own:  # each channel narrows the frames that the next one has to evaluate
        frames = frames[np.abs(np.array([curve.evaluate(frame) for frame in frames]) - now[curve.array_index]) < _AT_REST]
        if not len(frames):
            return False
    return bool(own)


def _rests(bone: bpy.types.PoseBone) -> bool:
    """Return whether a bone's own rotation is zero."""
    return abs(bone.matrix_basis.to_quaternion().angle) < _AT_REST


def keyed_bones(armature: ArmatureObject, what: str = "rotation") -> tuple[set[str], set[str]]:
    """Return the names of the bones whose rotation (or location) is keyed by this package's actions, and by other actions."""
    ours, theirs = set(), set()
    animation = armature.animation_data
    if animation is None:
        return ours, theirs
    actions = [animation.action, *(strip.action for track in animation.nla_tracks for strip in track.strips)]
    for action in {action for action in actions if action is not None}:
        names = ours if provenance.read(action) is not None else theirs
        names |= {dependencies.bone_of(curve.data_path) for curve in compat.curves(action) if f".{what}" in curve.data_path}
    return ours - theirs, theirs
