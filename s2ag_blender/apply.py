"""A motion onto a character: frame rate, retargeting, one new action."""

import logging
from collections.abc import Callable

import bpy
import numpy as np

from ..core.errors import UsageError
from ..core.motion import Motion, cubic
from ..rigs.goals import Options
from ..rigs.plain import Mapping
from . import compat, dependencies, keyframes, rig, rig_solver
from .controls import Take

_LOG = logging.getLogger(__name__)


def apply_motion(
    armature: bpy.types.Object,
    motion: Motion,
    start_frame: int | None = None,
    *,
    scene: bpy.types.Scene | None = None,
    mapping: Mapping | dict | None = None,
    options: Options | None = None,
    step: int = 1,
    strip: bool = False,
    name: str = "",
    report: Callable[[str], None] | None = None,
) -> bpy.types.Action:
    """Key ``motion`` on the bones of ``armature`` and return the new action.

    The first key is at ``start_frame`` (the scene's first frame), one every ``step`` frames at the scene's frame rate.
    The action becomes the active one, the former gets a fake user; with ``strip`` it goes onto a new NLA track instead
    and the active action stays. ``mapping`` is ``{part: bone or bones}``, detected if None. Everything that keeps a
    part from moving as asked is told to ``report``, one sentence each (the log, if None).

    Only adds data: other actions, the rest pose, transforms and rotation modes stay as they are. A setting that the rig
    needs to follow its bones, such as a switch from IK to FK, is keyed in the action; :func:`take_off` puts it back.
    Raises :class:`RigUnusable` or :class:`UsageError` before anything is changed.
    """
    if step < 1 or int(step) != step:
        raise UsageError(f"A key every {step} frames is not possible.", "Use a whole number of at least 1.")
    rig.require_armature(armature)
    scene, tell = scene or bpy.context.scene, report or _LOG.warning
    bones = rig.read(armature)
    mapping = rig.resolve_mapping(armature, bones, mapping)
    for warning in mapping.warnings:
        tell(warning)

    start = scene.frame_start if start_frame is None else start_frame
    offsets, directions, rate = at_scene_frames(motion, scene_fps(scene), int(step))
    keys = Take(directions, rate, start + offsets)
    given = start + np.arange(len(motion.directions)) * (scene_fps(scene) / motion.fps)
    whole = Take(motion.directions, motion.fps, given)
    found = rig_solver.solve(armature, bones, mapping, whole, keys, scene=scene, options=options, tell=tell)

    interpolation = "LINEAR" if step == 1 else "BEZIER"
    name = name or f"{armature.name} gesture"
    action, slot = keyframes.write_action(name, armature, found.rotations, keys.frames, interpolation, found.values)
    keyframes.stamp(action, motion.meta)
    keyframes.remember(action, armature)
    if strip:
        _push(armature, action, slot, int(start))
    else:
        _activate(armature, action, slot)
    return action


def take_off(armature: bpy.types.Object, action: bpy.types.Action) -> None:
    """Take a keyed motion off ``armature`` again, and give the rig back the pose and the settings that it had before.

    Blender itself leaves everything at its last value when an action goes. The action stays in the file.
    """
    animation = armature.animation_data
    if animation is not None:
        for track in list(animation.nla_tracks):
            for strip in [strip for strip in track.strips if strip.action == action]:
                track.strips.remove(strip)
            if not len(track.strips) and track.name == action.name:
                animation.nla_tracks.remove(track)
        if animation.action == action:
            animation.action = None
    for path, value in keyframes.former(action).items():
        dependencies.set_value(armature, path, value)
    armature.update_tag()


def scene_fps(scene: bpy.types.Scene) -> float:
    """Frames a second of a scene, such as 24 / 1.001."""
    return scene.render.fps / scene.render.fps_base


def at_scene_frames(motion: Motion, fps: float, step: int = 1) -> tuple[np.ndarray, np.ndarray, float]:
    """Frame offsets ``(keys,)``, directions ``(keys, 9, 3)`` at them, and keys a second, for keys every ``step`` frames.

    The last key is at or after the motion's end, so that nothing of it is lost.
    """
    last = int(np.ceil((len(motion.directions) - 1) * fps / motion.fps / step - 1e-6))
    offsets = np.arange(last + 1) * step
    return offsets, cubic(motion.directions, offsets * (motion.fps / fps)), fps / step


def _activate(armature, action, slot) -> None:
    former = armature.animation_data.action if armature.animation_data else None
    if former is not None and former.library is None:
        former.use_fake_user = True
    compat.assign_action(armature, action, slot)


def _push(armature, action, slot, start: int) -> None:
    track = armature.animation_data_create().nla_tracks.new()
    track.name = action.name
    compat.strip_slot(track.strips.new(action.name, start, action), slot)
