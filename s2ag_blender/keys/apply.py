"""Keys a motion on a character: conversion of the frame rate, retargeting, and one new action."""

import logging
from collections.abc import Callable, Generator
from dataclasses import replace
from typing import Any, NamedTuple

import bpy
import numpy as np

from ...core.errors import UsageError
from ...core.motion.motion import MAX_FPS, Motion
from ...rigs.goals import Options
from ...rigs.proportions import TrunkShape
from ...rigs.skeleton import Mapping
from ...rigs.slices import run_to_end
from .. import compat, provenance
from ..datablocks import ArmatureObject, Slot, current_context
from ..rig import body_shape, reading, solver
from ..rig.controls import Take
from . import faces, keyframes

_LOG = logging.getLogger(__name__)
_AROUND = 6.0
"""Seconds of a loop that are solved before its start and after its end: the twist of straight arms is led from bent ones."""


def apply_motion(armature: ArmatureObject, motion: Motion, start_frame: int | None = None, **about: Any) -> bpy.types.Action:
    """Run :func:`apply_motion_in_slices` in one go."""
    return run_to_end(apply_motion_in_slices(armature, motion, start_frame, **about))


def apply_motion_in_slices(
    armature: ArmatureObject, motion: Motion, start_frame: int | None = None, *, scene: bpy.types.Scene | None = None,
    mapping: Mapping | dict | None = None, options: Options | None = None, step: int = 1, strip: bool = False, name: str = "",
    report: Callable[[str], None] | None = None, change: "Callable[[Keys], Keys]" = lambda keys: keys
) -> Generator[None, None, bpy.types.Action]:  # fmt: skip
    """Key ``motion`` on the bones of ``armature`` and return the new action, yielding where Blender may draw.

    The first key is at ``start_frame`` (the scene's first frame), one every ``step`` frames at the scene's frame rate.
    The action becomes the active one, the former gets a fake user; with ``strip`` it goes onto a new NLA track instead
    and the active action stays. ``mapping`` is ``{part: bone or bones}``, detected if None. ``report`` gets one sentence
    for everything that keeps a part from its motion (the log, if None). ``change`` has the last word on the keys.

    Only adds data: other actions, the rest pose, transforms and rotation modes stay as they are. A property that the rig
    needs to follow its bones, such as a switch from IK to FK, is keyed in the action.
    Raises :class:`RigUnusable` or :class:`UsageError` before anything is changed."""
    if step < 1 or int(step) != step:
        raise UsageError(f"A key every {step} frames is not possible.", "Use a whole number of at least 1.")
    reading.require_armature(armature)
    yield  # what that has imported takes as long as a slice
    scene = scene or current_context().scene
    start = scene.frame_start if start_frame is None else start_frame
    told = {"mapping": mapping, "options": options, "report": report}
    keys = change((yield from solve_keys_in_slices(armature, motion, start, scene=scene, step=int(step), **told)))
    about = {"settings": keys.settings, "places": keys.places, "interpolation": "LINEAR" if step == 1 else "BEZIER"}
    name = name or f"{armature.name} gesture"
    action, slot = yield from keyframes.write_action(name, armature, keys.rotations, keys.frames, **about)
    provenance.stamp(action, motion.meta)
    every, fps = np.arange(float(start), float(max(keys.frames[-1], keys.frames[0] + 1)) + 1), scene_fps(scene)
    seen = None if motion.meta.get("loops") else faces.end_fade(every, fps)
    if motion.face is not None:
        spoken = faces.bone_channels(armature, motion.face, start, every, fps, keys.mapping, seen)
        keyframes.write_channels(compat.bag(action, slot), spoken, every)
    keyframes.store_former_values(action, armature)
    yield
    if motion.face is not None:
        faces.key_face(armature, action, motion.face, start, every, fps, report or _LOG.warning, seen)
        faces.show(armature, action)
    if strip:
        _push_strip(armature, action, slot, int(start))
    else:
        _make_active(armature, action, slot)
    return action


class Keys(NamedTuple):
    """Scene ``frames`` (keys,), ``rotations`` ``{bone: (keys, 4)}``, or (1, 4) if constant, and ``settings`` by data path.

    ``places`` ``{bone: (keys, 3)}`` are locations of the pelvis where the weight shifts; ``stood`` are the pelvis and the
    bones of the legs; ``mapping`` is the one that was used."""

    frames: np.ndarray
    rotations: dict[str, np.ndarray]
    settings: dict[str, float]
    places: dict[str, np.ndarray]
    stood: tuple[str, ...]
    mapping: Mapping

    def of_loop(self, around: int) -> "Keys":
        """Return the keys without so many at each end, the last ones the first again."""
        kept = slice(around, len(self.frames) - around)
        rotations, places = (
            {name: values[kept] if len(values) > 1 else values for name, values in one.items()}
            for one in (self.rotations, self.places)
        )
        for turn in rotations.values():
            turn[-1] = turn[0] * np.sign(turn[0] @ turn[-1])
        return self._replace(frames=self.frames[kept], rotations=rotations, places=places)


def solve_keys(armature: ArmatureObject, motion: Motion, start: float, **about: Any) -> Keys:
    """Run :func:`solve_keys_in_slices` in one go."""
    return run_to_end(solve_keys_in_slices(armature, motion, start, **about))


def solve_keys_in_slices(
    armature: ArmatureObject, motion: Motion, start: float, *, scene: bpy.types.Scene, mapping: Mapping | dict | None = None,
    options: Options | None = None, step: int = 1, first: float = -np.inf, last: float = np.inf, measured: int = 1,
    report: Callable[[str], None] | None = None, trunk: Callable[[], TrunkShape | None] | None = None
) -> Generator[None, None, Keys]:  # fmt: skip
    """Compute the keys for ``motion`` starting at frame ``start``, in slices; a rig's ``settings`` let it follow these keys.

    Only frames from ``first`` to ``last`` are computed. A control rig is measured at every ``measured``-th frame of the
    motion and interpolated between them, which is quick and approximate. ``trunk`` returns the shape of the trunk, for
    callers that have read it before, which is slow. Changes nothing. Raises :class:`RigUnusable` for an unusable rig and
    :class:`UsageError` where the motion has no frame in that range."""
    tell = report or _LOG.warning
    bones = reading.read(armature)
    mapping = reading.resolve_mapping(armature, bones, mapping)
    for warning in mapping.warnings:
        tell(warning)
    fps = scene_fps(scene)
    offsets, shown = at_scene_frames(motion, fps, step)
    around = round(_AROUND * fps / step) if motion.meta.get("loops") and not np.isfinite([first, last]).any() else 0
    if around:  # what comes before its start is its end
        offsets = step * np.arange(-around, len(offsets) + around)
        motion = shown = shown.frames(offsets // step % (len(shown.directions) - 1))
    frames = start + offsets
    inside = (frames >= first) & (frames <= last)
    if not inside.any():
        raise UsageError("The recording has no frame in the chosen range.", "Choose another range or start frame.")
    keys = _to_take(shown.frames(inside), frames[inside])
    own = frames[0] + np.arange(len(motion.directions)) * (fps / motion.fps)
    near = np.flatnonzero(np.abs(own - np.clip(own, keys.frames[0], keys.frames[-1])) <= 2 * fps / motion.fps)
    near = np.union1d(near[::measured], near[-1:])
    source = _to_take(replace(motion.frames(near), fps=motion.fps / measured), own[near])
    yield
    body = trunk() if trunk else body_shape.read_trunk(armature, bones, mapping)
    yield
    options = replace(options or Options(), sight="audio" in motion.meta)
    about = {"scene": scene, "options": options, "tell": tell, "trunk": body}
    solution = yield from solver.solve_in_slices(armature, bones, mapping, source, keys, **about)
    solved = Keys(keys.frames, solution.rotations, solution.values, solution.places, solution.stood, mapping)
    return solved.of_loop(around) if around else solved


def scene_fps(scene: bpy.types.Scene) -> float:
    """Return the frames per second of a scene, such as 24 / 1.001."""
    return scene.render.fps / scene.render.fps_base


def require_rate(scene: bpy.types.Scene) -> None:
    """Raise :class:`UsageError` for a frame rate with which memory would not suffice: its base is small by mistake."""
    if not scene_fps(scene) <= MAX_FPS:
        what = f"The scene has {scene_fps(scene):g} frames a second."
        raise UsageError(what, f"Set a frame rate of at most {MAX_FPS:g} in its output properties.")


def at_scene_frames(motion: Motion, fps: float, step: int = 1) -> tuple[np.ndarray, Motion]:
    """Return frame offsets ``(keys,)`` for keys every ``step`` frames, and the motion resampled to them.

    The last key is at or after the motion's end, so that nothing of it is cut off."""
    offsets = step * np.arange(1 + int(np.ceil((len(motion.directions) - 1) * fps / motion.fps / step - 1e-6)))
    return offsets, motion.at(offsets * (motion.fps / fps), fps / step)


def _to_take(motion: Motion, frames: np.ndarray) -> Take:
    return Take(motion.directions, motion.fps, frames, motion.hands, motion.pelvis)


def _make_active(armature: ArmatureObject, action: bpy.types.Action, slot: Slot | None) -> None:
    former = armature.animation_data.action if armature.animation_data else None
    if former is not None and former.library is None:
        former.use_fake_user = True
    compat.assign_action(armature, action, slot)


def _push_strip(armature: ArmatureObject, action: bpy.types.Action, slot: Slot | None, start: int) -> None:
    track = armature.animation_data_create().nla_tracks.new()
    track.name = action.name
    compat.strip_slot(track.strips.new(action.name, start, action), slot)
