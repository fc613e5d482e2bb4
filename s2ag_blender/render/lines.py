"""Keys many motions on one character and writes its animation alone: ``python -m s2ag.s2ag_blender.render.lines JOB.json``.

The job is JSON of :mod:`s2ag.core.cli.lines`: ``character``, ``gender``, ``armature``, ``maps`` (bone and face map), ``fps``,
``lines`` (``{name: .npz}``), ``settle``, seconds in which they leave the pose that all share, ``output``, and ``each``, a kind
of file for every line in the folder ``output``, or None."""

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ...core import json_text
from ...core.files import atomic_file
from ...core.motion import rest
from ...core.motion.interpolation import ramp
from ...core.motion.motion import Motion
from ...core.synthesis import hand_synthesis
from ...rigs import maps
from ...rigs.faces import shapes
from .. import compat, program
from ..characters import loading
from ..characters.character import Character
from ..datablocks import ArmatureObject
from ..keys import apply, blending, layers
from ..rig import facemaps
from . import export, job, vrm_animation


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(json_text.read(path), voice), "lines job")


def perform(asked: dict, voice: program.EventWriter) -> dict:
    """Do the job in this Blender; return the ``result`` event's content: warnings, and the bone or object that is the root."""
    bone_map, face_map = asked["maps"]
    warnings: list[str] = []
    with voice.stage("character"):
        wanted = (asked["character"], asked["gender"], asked["armature"], maps.load(bone_map) if bone_map else None)
        scene, (character,), _ = loading.build_scene([wanted])
        armature = character.armature
        if face_map:
            facemaps.store_face_map(armature, shapes.load(face_map))
        job._set_rate(scene, asked["fps"])
        _clear(armature)
    actions = {}
    with voice.stage("keyframes"):
        for number, (name, path) in enumerate(asked["lines"].items()):
            about, motion = {"scene": scene, "mapping": character.mapping, "report": warnings.append}, Motion.load(path)
            if not motion.meta.get("loops"):
                pose = _resting_pose(armature, motion.hands is not None, about)
                about["change"] = partial(_settled, pose=pose, frames=asked["settle"] * asked["fps"])
            actions[name] = apply.apply_motion(armature, motion, 0, name=name, **about)
            voice.progress("keyframes", number / len(asked["lines"]))
    alone = replace(character, meshes=())
    with voice.stage("write"):
        if asked["each"]:
            for name, action in actions.items():
                compat.assign_action(armature, action, layers.slot_of(armature, action))
                scene.frame_start, scene.frame_end = (round(value) for value in action.frame_range)
                write = vrm_animation.write if asked["each"] == "vrma" else export.export
                write(scene, alone, Path(asked["output"]) / f"{name}.{asked['each']}")
        else:
            _stash(armature, list(actions.values()))
            _write_all(alone, Path(asked["output"]))
    return {"warnings": warnings, "root": armature.data.bones[0].name}


def _clear(armature: ArmatureObject) -> None:
    """Remove the animation that came with the character's file, which is not saved: it would be written, too."""
    armature.animation_data_clear()
    for action in list(bpy.data.actions):
        bpy.data.actions.remove(action)


def _resting_pose(armature: ArmatureObject, hands: bool, about: dict) -> dict[str, np.ndarray]:
    """Return the pose ``{bone: (4,)}`` in which every line begins and ends."""
    home = np.repeat(rest.REST[None], 2, 0)
    keys = apply.solve_keys(armature, Motion(home, hands=hand_synthesis.hanging_hands(home) if hands else None), 0, **about)
    return {bone: values[0] for bone, values in keys.rotations.items()}


def _settled(keys: apply.Keys, pose: dict[str, np.ndarray], frames: float) -> apply.Keys:
    """Return keys that lead from ``pose`` and back to it, in so many frames each: what keeps arms out of the body lasts longer
    than their gesture does."""
    at, end = keys.frames - keys.frames[0], keys.frames[-1] - keys.frames
    near = min(frames, at[-1] / 2)
    moving = {bone: values for bone, values in keys.rotations.items() if len(values) > 1}
    return keys._replace(rotations=keys.rotations | blending.mix(moving, pose, ramp(at, 0, near) * ramp(end, 0, near)))


def _stash(armature: ArmatureObject, actions: list[bpy.types.Action]) -> None:
    """Put every action onto a muted track of its own, where exporters find it by its name."""
    data = armature.animation_data_create()
    slots = [layers.slot_of(armature, action) for action in actions]
    data.action = None
    for action, slot in zip(actions, slots, strict=True):
        track = data.nla_tracks.new()
        track.name, track.mute = action.name, True
        compat.strip_slot(track.strips.new(action.name, 0, action), slot)


def _write_all(character: Character, path: Path) -> None:
    """Write the skeleton with all actions as one ``.fbx`` or ``.glb``."""
    with atomic_file(path) as temporary, export._selected(character):
        about = {"filepath": str(temporary), "check_existing": False, "use_selection": True}
        if path.suffix.lower() == ".glb":
            about |= {"export_format": "GLB", "export_animation_mode": "ACTIONS", "export_force_sampling": True}
            about |= {"export_frame_range": False, "export_anim_slide_to_zero": True, "export_optimize_animation_size": False}
            bpy.ops.export_scene.gltf(**about)
        else:
            about |= {"bake_anim_use_all_actions": True, "bake_anim_use_nla_strips": False, "bake_anim_simplify_factor": 0.0}
            bpy.ops.export_scene.fbx(object_types={"ARMATURE"}, add_leaf_bones=False, **about)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
