"""Whom a character talks with: where that one stands, and when it speaks."""

from typing import Any

import bpy
import numpy as np

from ...core.errors import S2agError
from .. import compat
from ..datablocks import ArmatureObject
from ..keys import posing
from ..keys.apply import scene_fps
from . import retiming, sources, takes

_SIDE = 90.0
"""Degrees to either side within which the other one is looked at."""


def asked(armature: ArmatureObject, scene: bpy.types.Scene, voice: sources.Voice, settings: Any, figure: tuple) -> dict:
    """The engine's parameters of whom ``armature`` talks with: ``toward``, and ``hears`` with ``later`` where it has a voice.

    ``figure`` is what :func:`posing.canonical` needs beside the character.
    """
    other = settings.partner
    if other is None or other == armature or other.name not in scene.objects:
        return {}
    found = {"toward": toward(armature, other, *figure)}
    if settings.listen or settings.turn.strip():  # who speaks is known
        return found
    theirs = _voice(other, scene)
    if theirs is None or sources.same(theirs[0], voice.path):
        return found
    return found | {"hears": theirs[0], "later": round((theirs[1] - voice.span.start) / scene_fps(scene), 4)}


def toward(armature: ArmatureObject, other: bpy.types.Object, bones, mapping) -> float:
    """Degrees to the left of straight ahead at which ``other`` stands."""
    way = armature.matrix_world.inverted() @ other.matrix_world.translation
    right, _, ahead = posing.canonical(armature, bones, mapping, np.array(way, float))
    return round(float(np.clip(np.degrees(np.arctan2(-right, ahead)), -_SIDE, _SIDE)), 1)


def _voice(other: bpy.types.Object, scene: bpy.types.Scene) -> tuple[str, float] | None:
    """The recording of another character, and the frame at which it begins: of the take that it plays, else as it is set."""
    take = takes.active(other) if other.type == "ARMATURE" else None
    strip = retiming.strip_of(take.action, scene) if take is not None else None
    try:
        if strip is not None and strip.sound is not None:
            return sources.strip_file(strip), compat.strip_start(strip)
        if other.type != "ARMATURE" or other.s2ag.audio_source == "MIXDOWN" or sources.missing(other.s2ag, scene):
            return None
        found = sources.voice(other.s2ag, scene)
        return found.path, found.span.start
    except S2agError:  # it has none yet, and is only looked at
        return None
