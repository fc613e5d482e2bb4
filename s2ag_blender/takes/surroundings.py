"""The poses before and after a piece of a recording that is made anew: the engine performs from the ones to the others."""

from typing import Any

import bpy
import numpy as np

from ...core.motion import skeleton
from .. import provenance
from ..datablocks import ArmatureObject
from ..keys import apply, layers, posing

SEEN = 1.0
"""Seconds on either side; a network that draws its way between given frames sees their speed as well as their place."""


def poses(armature: ArmatureObject, scene: bpy.types.Scene, span, settings: Any, figure: tuple) -> list | None:
    """Frames of the motion and their directions ``[[n], [n x 9 x 3]]`` as the engine keeps them, None where nothing is around.

    ``span`` is that of the voice, ``figure`` what :func:`posing.directions` needs beside the character. Where the start or
    the end is the pose that the character has now, what is around it on that side does not count, and layers add to it.
    """
    if not span.piece or settings.result == "LAYER":
        return None
    shown = layers.draft_of(armature)
    told = provenance.of(shown) if shown is not None else {}
    if told.get("around") and told["start"] == span.start and layers.Place.of(shown).overlaps(span.first, span.last):
        return told["around"]
    if not layers.is_animated(armature, layers.base_action(armature, span.first, span.last, piece=True)):
        return None
    numbers, at = _frames(span, apply.scene_fps(scene), settings)
    return [numbers.tolist(), _seen(armature, scene, at, figure)] if len(numbers) else None


def _frames(span, fps: float, settings: Any) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the motion's frames that are around the span, and where they lie in the scene."""
    one, room = fps / skeleton.FPS, SEEN * fps
    numbers = np.arange(max(int((span.length - 1) / one) - 1, 0))  # strips are as long as their sound or a frame longer
    at = span.start + one * numbers
    before = (at < span.first) & (at >= span.first - room) & (settings.start_pose != "CURRENT")
    after = (at > span.last) & (at <= span.last + room) & (settings.end_pose != "CURRENT")
    near = before | after
    return numbers[near], at[near]


def _seen(armature: ArmatureObject, scene: bpy.types.Scene, at: np.ndarray, figure: tuple) -> list:
    """What the character shows at frames of the scene, as directions."""
    current, found = (scene.frame_current, scene.frame_subframe), []
    for frame in at.tolist():
        scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
        found.append(posing.directions(armature, *figure).round(5).tolist())
    scene.frame_set(current[0], subframe=current[1])
    return found
