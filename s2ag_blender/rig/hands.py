"""Which bones beside the gesture's own may be keyed without taking anything from the user: hands, fingers, twist bones."""

import bpy
from mathutils import Quaternion

from .. import compat, provenance
from . import dependencies

_REST = 1e-4
"""Largest departure of a rotation from none that still counts as rest."""
EASE = "s2ag_ease"
"""A posed bone's property: the rotation (4,) that its character came with, which is nobody's work to be kept."""


def free_bones(armature: bpy.types.Object, ruled: bool = False, eased: bool = False) -> set[str]:
    """Names of bones that rest, or that only this package's actions have keyed, and that nothing else turns.

    A bone that the user posed or keyed, that is locked, or that a constraint or a driver rules is left to them; the last
    two are not, if ``ruled``. With ``eased``, hands at ease that a character came with are free as well.
    """
    ours, theirs = keyed(armature)
    if not ruled:
        theirs |= {dependencies.bone_of(curve.data_path) for curve in dependencies.drivers(armature)}
        theirs |= set(dependencies.pulled(armature))
    return {
        bone.name
        for bone in armature.pose.bones
        if bone.name not in theirs
        and not any(bone.lock_rotation)
        and (ruled or not any(one.influence > 0 and not one.mute for one in bone.constraints))
        and (bone.name in ours or _rests(bone) or (eased and _at_ease(bone)))
    }


def eased(armature: bpy.types.Object) -> list[str]:
    """Names of the bones that still have the rotation that their character came with."""
    return [bone.name for bone in armature.pose.bones if _at_ease(bone)]


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
