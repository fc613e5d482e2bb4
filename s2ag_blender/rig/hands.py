"""Which bones beside the gesture's own may be keyed without taking anything from the user: hands, fingers, twist bones."""

import bpy
import numpy as np
from mathutils import Quaternion

from .. import compat, provenance
from . import dependencies

_REST = 1e-4
"""Largest departure of a rotation from none that still counts as rest."""
EASE = "s2ag_ease"
"""A posed bone's property: the rotation (4,) that its character came with, which is nobody's work to be kept."""


def free_bones(armature: bpy.types.Object, ruled: bool = False, eased: bool = False) -> set[str]:
    """Names of bones that rest, or that only this package's actions have keyed or left so, and that nothing else turns.

    A bone that the user posed or keyed, that is locked, or that a constraint or a driver rules is left to them; the last
    two are not, if ``ruled``. With ``eased``, hands at ease that a character came with are free as well.
    """
    ours, theirs = keyed(armature)
    if not ruled:
        theirs |= {dependencies.bone_of(curve.data_path) for curve in dependencies.drivers(armature)}
        theirs |= set(dependencies.pulled(armature))
    bones = {
        bone.name: bone.name in ours or _rests(bone) or (eased and _at_ease(bone))
        for bone in armature.pose.bones
        if bone.name not in theirs
        and not any(bone.lock_rotation)
        and (ruled or not any(one.influence > 0 and not one.mute for one in bone.constraints))
    }
    return {name for name, free in bones.items() if free} | left_over(armature, [name for name in bones if not bones[name]])


def eased(armature: bpy.types.Object) -> list[str]:
    """Names of the bones that still have the rotation that their character came with."""
    return [bone.name for bone in armature.pose.bones if _at_ease(bone)]


def left_over(armature: bpy.types.Object, names: list[str], what: str = "rotation") -> set[str]:
    """Those of bones ``names`` whose rotation (or location) an action of this package gives at one of its frames.

    Blender leaves the pose standing when an action goes: that is nobody's work to be kept.
    """
    found = set()
    for action in bpy.data.actions if names else ():
        if provenance.of(action) is None:
            continue
        curves, (first, last) = {}, action.frame_range
        for curve in compat.curves(action):
            curves.setdefault(curve.data_path, []).append(curve)
        frames = np.arange(np.floor(first), np.ceil(last) + 1)
        found |= {name for name in names if name not in found and _given(armature.pose.bones[name], what, curves, frames)}
    return found


def _given(bone: bpy.types.PoseBone, what: str, curves: dict[str, list[bpy.types.FCurve]], frames: np.ndarray) -> bool:
    """Whether ``curves`` by data path put a bone where it is at one of the ``frames``."""
    kinds = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
    name = kinds.get(bone.rotation_mode, "rotation_euler") if what == "rotation" else what
    own, now = curves.get(bone.path_from_id(name), ()), getattr(bone, name)
    for curve in own:  # of the first channel all frames are asked, of the next ones those that are left
        frames = frames[np.abs(np.array([curve.evaluate(frame) for frame in frames]) - now[curve.array_index]) < _REST]
        if not len(frames):
            return False
    return bool(own)


def _rests(bone: bpy.types.PoseBone) -> bool:
    """Whether a bone's own rotation is none."""
    return abs(bone.matrix_basis.to_quaternion().angle) < _REST


def _at_ease(bone: bpy.types.PoseBone) -> bool:
    """Whether a bone still has the rotation that its character came with."""
    came = bone.get(EASE)
    return came is not None and bone.matrix_basis.to_quaternion().rotation_difference(Quaternion(came)).angle < _REST


def keyed(armature: bpy.types.Object, what: str = "rotation") -> tuple[set[str], set[str]]:
    """Names of the bones whose rotation (or location) actions of this package key, and of those that others key."""
    ours, theirs = set(), set()
    animation = armature.animation_data
    if animation is None:
        return ours, theirs
    actions = [animation.action, *(strip.action for track in animation.nla_tracks for strip in track.strips)]
    for action in {action for action in actions if action is not None}:
        names = ours if provenance.of(action) is not None else theirs
        names |= {dependencies.bone_of(curve.data_path) for curve in compat.curves(action) if f".{what}" in curve.data_path}
    return ours - theirs, theirs
