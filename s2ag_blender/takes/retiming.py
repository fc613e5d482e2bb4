"""A take whose sound strip was moved follows it: keys, markers and what is remembered of it, each as far as the sound."""

import json

import bpy
import numpy as np

from ...core.errors import UsageError
from .. import compat, provenance
from ..keys import faces, keyframes, layers
from . import markers, recall, sources, takes, versions, voices

_LEAST = 0.5
"""Frames by which a strip must have moved to count as moved."""


def strip_of(action: bpy.types.Action, scene: bpy.types.Scene):
    """The sound strip that a take was made for or came with, or None."""
    tag = action.get(voices.TAG, "")
    if tag:
        return next((strip for strip in compat.sound_strips(scene) if strip.get(voices.TAG) == tag), None)
    told = provenance.of(action)
    return sources.chosen_strip(recall.view(told["settings"]), scene) if told and "settings" in told else None


def moved(action: bpy.types.Action, scene: bpy.types.Scene) -> float:
    """By how many frames the sound was moved since the take was made; 0 where it lies as it lay, or is not there."""
    told, strip = provenance.of(action), strip_of(action, scene)
    if not told or "start" not in told or strip is None:
        return 0.0
    by = compat.strip_start(strip) - told["start"]
    return by if abs(by) >= _LEAST else 0.0


def follow(armature: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Move the selected take, with all its versions, to where its sound is now; returns by how many frames.

    Raises :class:`UsageError` where nothing has moved, or the take lies within other animation, which stays.
    """
    take = takes.active(armature)
    by, place = moved(take.action, scene), layers.Place.of(take.action)
    if not by or place is None:
        raise UsageError("The sound strip lies where it lay.", "Move it in the sequencer first.")
    if place.result == "ACTION" and layers.base_action(armature, place.first, place.last, place.piece) is not None:
        raise UsageError("The take lies within other animation, which would move, too.", "Generate it anew, or use a layer.")
    every = versions.actions(take)
    prefix = armature.s2ag.marker_prefix
    for marker in markers.ours(scene, prefix):
        if place.first <= marker.frame <= place.last:
            marker.frame = round(marker.frame + by)
    for action in every:
        _shift(action, by)
    takes.located(take)
    takes.show(armature)
    return by


def _shift(action: bpy.types.Action, by: float) -> None:
    told = provenance.of(action)
    whole = round(by)
    for one in dict.fromkeys([action, *faces.apart(action)]):
        for curve in compat.curves(one):
            keys = keyframes.columns(curve.keyframe_points)
            for name in ("co", "handle_left", "handle_right"):
                keys[name][:, 0] += np.float32(by)
            keyframes.replace(curve, keys)
        if one.use_frame_range:
            start, end = one.frame_start, one.frame_end
            one.frame_start, one.frame_end = start + by, end + by
    for marker in action.pose_markers:
        marker.frame += whole
    told["start"] += by
    told["place"] |= {name: told["place"][name] + whole for name in ("first", "last")}
    settings = told["settings"]
    if settings.get("audio_source") == "FILE" and settings.get("range") != "STRIP":
        settings |= {"range": "OWN", "start_frame": round(told["start"])}
    action[provenance.PROPERTY] = json.dumps(told, sort_keys=True)
