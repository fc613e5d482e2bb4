"""Reads the poses before and after a part of a recording, so that the engine can generate the part between them."""

from typing import Any

import bpy
import numpy as np

from ...core.motion import skeleton
from .. import provenance
from ..datablocks import ArmatureObject
from ..keys import apply, layers, poses

SEEN = 1.0
"""Seconds of poses on either side, from which the network also gets their speed."""


def poses_around(armature: ArmatureObject, scene: bpy.types.Scene, span: Any, settings: Any, figure: tuple) -> list | None:
    """Return frame numbers of the motion and their edge directions, ``[[n], [n x 9 x 3]]``; None if there are none.

    ``span`` is the voice's :class:`sources.Span`, ``figure`` are bones, mapping and options for :func:`poses.directions`.
    Sides on which the motion starts or ends with the current pose have no surroundings; neither have layers."""
    if not span.piece or settings.result == "LAYER":
        return None
    shown = layers.draft_of(armature)
    meta, place = provenance.read(shown) or {}, layers.Place.of(shown)
    if meta.get("around") and meta["start"] == span.start and place is not None and place.overlaps(span.first, span.last):
        return meta["around"]
    if not layers.is_animated(armature, layers.base_action(armature, span.first, span.last, piece=True)):
        return None
    numbers, at = _frames(span, apply.scene_fps(scene), settings)
    return [numbers.tolist(), _read_poses(armature, scene, at, figure)] if len(numbers) else None


def _frames(span: Any, fps: float, settings: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the motion's frames around the span, and their scene frames."""
    one, room = fps / skeleton.FPS, SEEN * fps
    numbers = np.arange(max(int((span.length - 1) / one) - 1, 0))  # strips are as long as their sound or a frame longer
    at = span.start + one * numbers
    before = (at < span.first) & (at >= span.first - room) & (settings.start_pose != "CURRENT")
    after = (at > span.last) & (at <= span.last + room) & (settings.end_pose != "CURRENT")
    near = before | after
    return numbers[near], at[near]


def _read_poses(armature: ArmatureObject, scene: bpy.types.Scene, at: np.ndarray, figure: tuple) -> list:
    """Return the edge directions of the character's poses at scene frames."""
    current, directions = (scene.frame_current, scene.frame_subframe), []
    for frame in at.tolist():
        scene.frame_set(int(np.floor(frame)), subframe=frame % 1.0)
        directions.append(poses.directions(armature, *figure).round(5).tolist())
    scene.frame_set(current[0], subframe=current[1])
    return directions
