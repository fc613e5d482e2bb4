"""Puts a gesture of several frames into what a character does already: as keys of its action or as a strip above it."""

from collections.abc import Callable
from dataclasses import replace

import bpy
import numpy as np

from ...core.editing import gesture_motion
from ...core.errors import UsageError
from ...core.meaning import gesture_selection
from ...core.motion import rest, skeleton
from ...core.motion.motion import Motion
from ...rigs.skeleton import PARTS
from ...rigs.slices import run_to_end
from .. import provenance
from ..datablocks import ArmatureObject
from ..keys import apply, layers, poses
from ..keys.action_builder import ActionBuilder
from ..rig import chosen_bones, reading
from . import drafts, gesture_edits, sources, stored_settings, timing
from .plans import Handle, Plan

perform = gesture_motion.perform_kind
"""Returns a kind of gesture as a motion."""
_STILL = np.radians(3.0)
"""A part of the body that moves less belongs to what the character does already."""
_EDGES = {"TORSO": (0,), "HEAD": (1, 2), "CLAVICLES": (3, 6), "LEFT_ARM": (4, 5), "RIGHT_ARM": (7, 8)}


def scaled(motion: Motion, size: float) -> Motion:
    """Return a motion whose arms are ``size`` times as far from where they hang; hands go with them."""
    arms, directions = list(skeleton.ARM_EDGES), motion.directions.copy()
    directions[:, arms] = rest.scale_amplitude(motion.directions[:, arms], size, rest.REST[arms])
    hands = motion.hands and motion.hands.moved_with_arms(motion.directions, directions)
    return replace(motion, directions=directions, hands=hands)


def moving_parts(motion: Motion) -> set[str]:
    """Return the parts of the body, as the character's settings name them, that a gesture moves."""
    turned = rest.angle_between(motion.directions, motion.directions[:1]).max(0)
    return {part for part, edges in _EDGES.items() if turned[list(edges)].max() > _STILL}


def frame_of_word(action: bpy.types.Action | None, scene: bpy.types.Scene, number: int) -> float:
    """Return the scene frame at which word ``number`` of a take, from 1, is loudest. Raises :class:`UsageError`."""
    words = gesture_edits.stored_words(action) if action is not None else []
    if action is None or number > len(words):
        raise UsageError(f"The selected take has no word {number}.", "Select a take with words, or insert at the playhead.")
    clock = timing.clock_of(provenance.require(action), apply.scene_fps(scene))
    return float(clock.frame(gesture_selection.emphasis_time(*words[number - 1][1:])))


def insert(
    armature: ArmatureObject, scene: bpy.types.Scene, motion: Motion, frame: int, *, strip: bool = False, blend_in: int = 12,
    blend_out: int = 10, name: str = "", report: Callable[[str], None] = print
) -> bpy.types.Action:  # fmt: skip
    """Key a gesture from ``frame`` on over what the character does there, and play the result; return its action.

    Only parts of the body that the gesture moves, and that the character's settings key, get keys. They begin in what is there,
    and return to it, within ``blend_in`` and ``blend_out`` frames. The action that played is copied, not changed; with
    ``strip``, or where the character plays strips alone, the gesture is a strip above it. ``report`` gets each warning. Raises
    :class:`S2agError`."""
    reading.require_armature(armature)
    apply.require_rate(scene)
    drafts.drop(armature)
    settings, rate = armature.s2ag, apply.scene_fps(scene)
    last = frame + int(np.ceil((len(motion.directions) - 1) * rate / motion.fps - 1e-6))
    base = layers.base_action(armature, frame, last, piece=True)
    playing = layers.strips(armature)
    strip = strip or bool(playing and base is None)
    kept = stored_settings.snapshot(settings) | {"blend_in": blend_in, "blend_out": blend_out, "influence": 1.0, "speed": 1.0}
    kept |= {"result": "STRIP" if strip else "ACTION", "parts": sorted(moving_parts(motion) & set(settings.parts))}
    animated = bool(playing or base) if strip else layers.is_animated(armature, base)
    kept |= {"start_pose": "REST", "end_pose": "FREE"} if animated else dict.fromkeys(("start_pose", "end_pose"), "CURRENT")
    mapping = chosen_bones.mapping_of_settings(settings)
    chains = reading.resolve_mapping(armature, reading.read(armature), mapping).chains
    pose = {} if animated else poses.current_rotations(armature, [bone for part in PARTS for bone in chains.get(part, ())])
    voice = sources.Voice("", sources.Span(frame, frame, last, last - frame + 2.0))
    about = stored_settings.options(settings)
    planned = Plan(Handle.of(armature), Handle.of(scene), {}, voice, kept, mapping, options=about, pose=pose, rate=rate)
    builder = ActionBuilder(planned, armature, scene, report)
    action = run_to_end(builder.acting(motion, run_to_end(builder.keying(motion)), []))
    action.name = f"{armature.name} {name or 'gesture'}"
    action.frame_start, action.frame_end = min(action.frame_start, frame), max(action.frame_end, last)  # of a copied take
    layers.show(armature, action)
    return action
