"""Shows and removes drafts: actions that a character plays while sliders move, until a take is made or the preview ends.

A draft is the active action. A layer's draft is combined with the animation below, as its strip would be; meanwhile the
former action is on a track of its own and the strip that the layer replaces is muted. The values to restore are stored on the
object, so that undo always restores both."""

import contextlib
import json
from typing import Any

import bpy

from .. import compat, json_properties
from ..datablocks import ArmatureObject, is_armature
from ..keys import faces, keyframes, layers

TRACK = "S2AG draft"
"""Name of the track with the former action below a layer's draft."""
STAGED = "s2ag_draft"
"""Custom property of an object: JSON of what a layer's draft changed."""
_BLENDING = {"action_blend_type": "COMBINE", "action_extrapolation": "NOTHING", "action_influence": 1.0}


def is_staged(armature: ArmatureObject) -> bool:
    """Return whether the character plays the draft of a layer."""
    return STAGED in armature


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Play a draft instead of the current one."""
    if layers.draft_of(armature) == action:
        if faces.FACES in action:
            faces.show(armature, action)
        return
    drop(armature)
    place, data = layers.Place.of(action), armature.animation_data_create()
    if data.action is not None:
        action[layers.BEFORE] = data.action
    if place is not None and place.result == "LAYER":
        _stage(armature, place)
    compat.assign_action(armature, action, layers.slot_of(armature, action))
    if faces.FACES in action:
        faces.show(armature, action)


def drop(armature: ArmatureObject) -> None:
    """Remove the draft and restore the former action and the former values of bones and switches."""
    action = layers.draft_of(armature)
    if armature.get(STAGED) is not None:
        _unstage(armature, json_properties.read(armature, STAGED))
    if action is not None:
        keyframes.restore_former_values(armature, action)
        layers.assign(armature, layers.below_draft(action))
        _restore_face(armature, action)
        bpy.data.actions.remove(action)


def _restore_face(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Restore the face that a draft's face replaced."""
    if faces.FACES not in action:
        return
    faces.hide(armature, action)
    for played in layers.playing_actions(armature):
        if faces.FACES in played:
            faces.show(armature, played)


def drop_all() -> None:
    """Remove the drafts of all characters."""
    for armature in [item for item in bpy.data.objects if is_armature(item)]:
        drop(armature)


def _stage(armature: ArmatureObject, place: layers.Place) -> None:
    """Set up the NLA for a layer's draft, and store what that changes."""
    data = armature.animation_data_create()
    former = data.action
    replaced = [strip for strip in layers.strips(armature) if not strip.mute and place.within(layers.Place.of(strip.action))]
    changed = {name: getattr(data, name) for name in _BLENDING} | {"muted": [strip.name for strip in replaced]}
    if former is not None:
        base = layers.base_action(armature, place.first, place.last, place.piece)
        if base is not None:
            layers.push_down(armature, base, layers.slot_of(armature, base)).name = TRACK
    for strip in replaced:
        strip.mute = True
    for name, value in _BLENDING.items():
        setattr(data, name, value)
    armature[STAGED] = json.dumps(changed)


def _unstage(armature: ArmatureObject, changed: dict[str, Any]) -> None:
    """Restore the NLA from before a layer's draft."""
    data, muted = armature.animation_data, changed.get("muted")
    muted = muted if isinstance(muted, list) else []
    if data is not None:
        for track in list(data.nla_tracks):
            if track.name == TRACK:
                data.nla_tracks.remove(track)
                continue
            for strip in track.strips:
                strip.mute = strip.mute and strip.name not in muted
        for name in _BLENDING:
            with contextlib.suppress(TypeError):  # the stored value has another type
                setattr(data, name, changed.get(name, _BLENDING[name]))
    del armature[STAGED]
