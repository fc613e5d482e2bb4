"""Takes a keyed motion off a rig again."""

import bpy
from s2ag.s2ag_blender.datablocks import ArmatureObject
from s2ag.s2ag_blender.keys import faces, keyframes


def remove_motion(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Remove a keyed motion from ``armature`` and restore the pose and property values that the rig had before.

    Blender itself leaves everything at its last value when an action is unassigned. The action stays in the file."""
    animation = armature.animation_data
    if animation is not None:
        for track in list(animation.nla_tracks):
            for strip in [strip for strip in track.strips if strip.action == action]:
                track.strips.remove(strip)
            if not len(track.strips) and track.name == action.name:
                animation.nla_tracks.remove(track)
        if animation.action == action:
            animation.action = None
    keyframes.restore_former_values(armature, action)
    faces.hide(armature, action)
