"""A motion onto a character: frame rate, retargeting, one new action."""

import logging
from collections.abc import Callable

import bpy
import numpy as np

from ..core.errors import UsageError
from ..core.motion import Motion, cubic
from ..rigs.plain import Mapping
from ..rigs.retarget import Options, solve
from . import compat, keyframes, rig

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

    Only adds data: other actions, the rest pose, transforms and rotation modes stay as they are. Raises
    :class:`RigUnusable` or :class:`UsageError` before anything is changed.
    """
    if step < 1 or int(step) != step:
        raise UsageError(f"A key every {step} frames is not possible.", "Use a whole number of at least 1.")
    rig.require_armature(armature)
    scene = scene or bpy.context.scene
    start = scene.frame_start if start_frame is None else start_frame
    frames, rotations = pose_keys(
        armature, motion, start, scene=scene, mapping=mapping, options=options, step=int(step), report=report
    )
    interpolation = "LINEAR" if step == 1 else "BEZIER"
    name = name or f"{armature.name} gesture"
    action, slot = keyframes.write_action(name, armature, rotations, frames, interpolation)
    keyframes.stamp(action, motion.meta)
    if strip:
        _push(armature, action, slot, int(start))
    else:
        _activate(armature, action, slot)
    return action


def pose_keys(
    armature: bpy.types.Object,
    motion: Motion,
    start: float,
    *,
    scene: bpy.types.Scene,
    mapping: Mapping | dict | None = None,
    options: Options | None = None,
    step: int = 1,
    first: float = -np.inf,
    last: float = np.inf,
    report: Callable[[str], None] | None = None,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Scene frames ``(keys,)`` and rotations ``{bone: (keys, 4)}`` at them for ``motion`` starting at frame ``start``.

    Only frames from ``first`` to ``last`` are made. Changes nothing. Raises :class:`RigUnusable` for an unusable rig and
    :class:`UsageError` where the motion has no frame in that range.
    """
    bones = rig.read(armature)
    mapping = rig.resolve_mapping(armature, bones, mapping)
    for warning in mapping.warnings:
        (report or _LOG.warning)(warning)
    offsets, directions, rate = at_scene_frames(motion, scene_fps(scene), step)
    frames = start + offsets
    inside = (frames >= first) & (frames <= last)
    if not inside.any():
        raise UsageError("The recording has no frame in the chosen range.", "Choose another range or start frame.")
    return frames[inside], solve(bones, mapping, directions[inside], rate, options)


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
