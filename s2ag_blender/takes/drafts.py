"""Drafts: what a character plays while sliders move, until a take comes or the preview ends.

A draft is the active action, over whatever the character played before. That of a layer is combined with what lies below,
as its strip would be; meanwhile the former action lies in a track of its own and the strip whose place the layer takes is
muted. What to put back stands on the object, so undo, which goes back to before or after all of it, cannot part them.
"""

import contextlib
import json

import bpy

from .. import compat, stored
from ..datablocks import ArmatureObject
from ..keys import faces, keyframes, layers

TRACK = "S2AG draft"
"""The track in which the former action lies below the draft of a layer."""
STAGED = "s2ag_draft"
"""Custom property of an object that says, as JSON, what the draft of a layer changed."""
_BLENDING = {"action_blend_type": "COMBINE", "action_extrapolation": "NOTHING", "action_influence": 1.0}


def is_staged(armature: ArmatureObject) -> bool:
    """Whether the character plays the draft of a layer."""
    return STAGED in armature


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Let the character play a draft instead of the one it plays."""
    if layers.draft_of(armature) == action:
        if faces.FACES in action:
            faces.show(armature, action)
        return
    drop(armature)
    place, data = layers.Place.of(action), armature.animation_data_create()
    if data.action is not None:
        action[layers.BEFORE] = data.action
    if place.result == "LAYER":
        _stage(armature, place)
    compat.assign_action(armature, action, layers.slot_of(armature, action))
    if faces.FACES in action:
        faces.show(armature, action)


def drop(armature: ArmatureObject) -> None:
    """Remove the draft; the character plays again what it played before, and its bones and switches stand as they stood."""
    action = layers.draft_of(armature)
    if armature.get(STAGED) is not None:
        _unstage(armature, stored.read(armature, STAGED))
    if action is not None:
        keyframes.give_back(armature, action)
        layers.assign(armature, action.get(layers.BEFORE))
        _face_back(armature, action)
        bpy.data.actions.remove(action)


def _face_back(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """The face that a draft's took the place of, if it had one."""
    if faces.FACES not in action:
        return
    faces.hide(armature, action)
    for played in layers.playing(armature):
        if faces.FACES in played:
            faces.show(armature, played)


def drop_all() -> None:
    """:func:`drop` every character's draft."""
    for armature in [item for item in bpy.data.objects if item.type == "ARMATURE"]:
        drop(armature)


def _stage(armature: ArmatureObject, place: layers.Place) -> None:
    data, former = armature.animation_data, armature.animation_data.action
    replaced = [strip for strip in layers.strips(armature) if not strip.mute and place.within(layers.Place.of(strip.action))]
    told = {name: getattr(data, name) for name in _BLENDING} | {"muted": [strip.name for strip in replaced]}
    if former is not None:
        base = layers.base_action(armature, place.first, place.last, place.piece)
        if base is not None:
            layers.push_down(armature, base, layers.slot_of(armature, base)).name = TRACK
    for strip in replaced:
        strip.mute = True
    for name, value in _BLENDING.items():
        setattr(data, name, value)
    armature[STAGED] = json.dumps(told)


def _unstage(armature: ArmatureObject, told: dict) -> None:
    data, muted = armature.animation_data, told.get("muted")
    muted = muted if isinstance(muted, list) else []
    for track in list(data.nla_tracks) if data else ():
        if track.name == TRACK:
            data.nla_tracks.remove(track)
            continue
        for strip in track.strips:
            strip.mute = strip.mute and strip.name not in muted
    for name in _BLENDING if data else ():
        with contextlib.suppress(TypeError):  # what was stored is of another kind
            setattr(data, name, told.get(name, _BLENDING[name]))
    del armature[STAGED]
