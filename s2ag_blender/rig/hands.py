"""Finds the bones beyond the mapped ones that may be keyed without overwriting the user's work: hands, fingers, twist bones."""

from typing import Any

import bpy
import numpy as np
from mathutils import Quaternion

from .. import compat, provenance
from ..datablocks import ArmatureObject
from . import dependencies

_AT_REST = 1e-4
"""A rotation counts as rest up to this difference (radians, or units of its channels)."""
EASE = "s2ag_ease"
"""Custom property of a pose bone: its relaxed rotation (4,) as the character came, which is no work of the user."""


def free_bones(armature: ArmatureObject, ruled: bool = False, eased: bool = False) -> set[str]:
    """Return the names of bones at rest, or posed only by this package's actions, that nothing else turns.

    Excludes bones that the user posed or keyed, that are locked, or that have an active constraint or a driver; ``ruled``
    includes those with constraints and drivers. ``eased`` includes bones that still have the character's relaxed rotation.
    """
    ours, theirs = keyed_bones(armature)
    if not ruled:
        theirs |= {dependencies.bone_of(curve.data_path) for curve in dependencies.drivers(armature)}
        theirs |= set(dependencies.ik_constraints(armature))
    bones = {
        bone.name: bone.name in ours or _rests(bone) or (eased and _at_ease(bone))
        for bone in armature.pose.bones
        if bone.name not in theirs
        and not any(bone.lock_rotation)
        and (ruled or not any(constraint.influence > 0 and not constraint.mute for constraint in bone.constraints))
    }
    return {name for name, free in bones.items() if free} | posed_by_former_actions(
        armature, [name for name in bones if not bones[name]]
    )


def eased_bones(armature: ArmatureObject) -> list[str]:
    """Return the names of the bones that still have the relaxed rotation with which the character came."""
    return [bone.name for bone in armature.pose.bones if _at_ease(bone)]


def posed_by_former_actions(armature: ArmatureObject, names: list[str], what: str = "rotation") -> set[str]:
    """Return those of ``names`` whose current rotation (or location) equals a frame of an action of this package.

    Blender keeps the last pose when an action is removed; such a pose is no work of the user.
    """
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


def _at_ease(bone: bpy.types.PoseBone) -> bool:
    """Return whether a bone still has the relaxed rotation with which the character came."""
    ease: Any = bone.get(EASE)
    kind = getattr(ease, "typecode", "")
    numbers = ease if kind in ("f", "d") and len(ease) == 4 else None
    return numbers is not None and bone.matrix_basis.to_quaternion().rotation_difference(Quaternion(numbers)).angle < _AT_REST


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
