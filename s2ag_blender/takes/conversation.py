"""Finds the conversation partner of a character: its direction, and its recording."""

from typing import Any

import bpy
import numpy as np

from ...core.errors import S2agError
from ...rigs.skeleton import Bones, Mapping
from .. import compat
from ..datablocks import ArmatureObject, is_armature
from ..keys import poses
from ..keys.apply import scene_fps
from . import retiming, sources, take_list

_MAX_DEGREES = 90.0
"""Largest angle to either side at which the partner is looked at."""


def conversation_parameters(
    armature: ArmatureObject, scene: bpy.types.Scene, voice: sources.Voice, settings: Any, figure: tuple[Bones, Mapping]
) -> dict[str, Any]:
    """Return the engine's parameters of the partner: ``toward``, and ``hears`` with ``later`` where it has a voice.

    ``figure`` are the bones and mapping for :func:`poses.to_canonical`."""
    other = settings.partner
    if other is None or other == armature or other.name not in scene.objects:
        return {}
    params = {"toward": toward(armature, other, *figure)}
    if settings.listen or settings.turn.strip():  # the recording itself says who speaks
        return params
    theirs = _voice(other, scene)
    if theirs is None or sources.is_same_file(theirs[0], voice.path):
        return params
    return params | {"hears": theirs[0], "later": round((theirs[1] - voice.span.start) / scene_fps(scene), 4)}


def toward(armature: ArmatureObject, other: bpy.types.Object, bones: Bones, mapping: Mapping) -> float:
    """Return the direction of ``other`` in degrees to the left of straight ahead."""
    way = armature.matrix_world.inverted() @ other.matrix_world.translation
    right, _, ahead = poses.to_canonical(armature, bones, mapping, np.array(way, float))
    return round(float(np.clip(np.degrees(np.arctan2(-right, ahead)), -_MAX_DEGREES, _MAX_DEGREES)), 1)


def _voice(other: bpy.types.Object, scene: bpy.types.Scene) -> tuple[str, float] | None:
    """Return the path and first frame of another character's recording: of its take, else of its settings."""
    if not is_armature(other):
        return None
    take = take_list.active(other)
    strip = retiming.strip_of_take(take.action, scene) if take is not None else None
    try:
        if strip is not None and strip.sound is not None:
            return sources.strip_file(strip), compat.strip_start(strip)
        if other.s2ag.audio_source == "MIXDOWN" or sources.missing_inputs(other.s2ag, scene):
            return None
        found = sources.find_voice(other.s2ag, scene)
        return found.path, found.span.start
    except S2agError:  # it has none yet, and is only looked at
        return None
