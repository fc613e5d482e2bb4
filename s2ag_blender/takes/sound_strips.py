"""Manages the sound strip of a run, which is audible while one of its takes is shown.

A strip of ours has a tag that is also stored on its takes. Strips of the user have none and are never changed."""

import uuid
from typing import Any

import bpy

from ...core.errors import AudioUnreadable
from .. import compat, json_properties
from ..datablocks import ArmatureObject, SoundStrip, is_armature
from ..keys.layers import Place
from ..render import sound
from ..translations import translate

TAG = "s2ag_voice"
"""Custom property of a strip of ours, and of the actions of its takes."""
_SILENCED = "s2ag_silenced"  # on strips that were muted here, not by the user


def add_strip(scene: bpy.types.Scene, path: str, start: int, name: str, wanted: bool = True) -> tuple[str, list[str]]:
    """Find the strip of a recording at a frame, or add it if ``wanted``; return its tag and messages for the user.

    The tag is "" if the strip is the user's or there is none."""
    others = [strip for strip in sound.of_file(scene, path) if TAG not in strip]
    strip = sound.playing(scene, path, start)
    if strip is None and not wanted:
        return "", []
    if strip is None:
        try:
            strip = sound.add_sound(scene, path, start, name)
        except AudioUnreadable as error:  # the engine reads more formats than Blender's sound system
            return "", [f"The gestures are there, the sound strip is not: {error}"]
        strip[TAG] = uuid.uuid4().hex
        compat.show_in_sequencers(scene)
    scene.sync_mode = "AUDIO_SYNC" if wanted else scene.sync_mode
    duplicates = [(one.name, round(compat.strip_start(one))) for one in others if one != strip and not one.mute]
    return json_properties.text(strip, TAG), [
        translate('Your strip "{name}" plays this recording at frame {frame}, too.', name=name, frame=frame)
        for name, frame in duplicates
    ]


def reload(sound: bpy.types.Sound) -> None:
    """Reload a sound from its file."""
    if sound.packed_file is None and sound.library is None:
        sound.filepath = sound.filepath  # setting the path makes Blender read the file again


def renew_strip(scene: bpy.types.Scene, strip: SoundStrip) -> SoundStrip:
    """Replace a strip of ours by a new one with the length of its sound, since strips keep their length on reload."""
    if TAG not in strip or strip.sound is None:
        return strip
    strips = _siblings(scene, strip)
    kept = {name: getattr(strip, name) for name in ("name", "mute", "volume", "channel")}
    path, start, tag = bpy.path.abspath(strip.sound.filepath), round(compat.strip_start(strip)), strip[TAG]
    strips.remove(strip)
    successor = strips.new_sound(kept["name"], path, kept["channel"], start)
    for name, value in kept.items():
        setattr(successor, name, value)
    successor[TAG] = tag
    return successor


def _siblings(scene: bpy.types.Scene, strip: Any) -> Any:
    """Return the strips of the meta strip or sequence editor that has a strip."""
    owner: Any = strip.parent_meta() or scene.sequence_editor
    return compat.sequencer_strips(owner)


def unmute_strip_of(armature: ArmatureObject, action: bpy.types.Action) -> list[str]:
    """Unmute the strip of the shown take and mute those of the character's other takes on its frames.

    Returns the names of newly muted strips. Strips of the user and of other characters' takes stay."""
    place, shown = Place.of(action), json_properties.text(action, TAG)
    if place is None:
        return []
    mine = {json_properties.text(take.action, TAG) for take in armature.s2ag.takes if take.action is not None}
    mine -= {shown, *_shown_elsewhere(armature)}
    silenced = []
    for strip in [one for scene in bpy.data.scenes for one in compat.sound_strips(scene) if TAG in one]:
        if (tag := json_properties.text(strip, TAG)) == shown:
            if strip.get(_SILENCED):
                strip.mute = False
                del strip[_SILENCED]
        elif tag in mine and not strip.mute and place.overlaps(
            round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
        ):
            strip.mute = strip[_SILENCED] = True
            silenced.append(strip.name)
    return silenced


def remove_unused() -> None:
    """Remove muted strips of ours that no take uses any more."""
    used = {json_properties.text(action, TAG) for action in bpy.data.actions}
    for scene in bpy.data.scenes:
        silenced = [strip for strip in compat.sound_strips(scene) if strip.get(_SILENCED)]
        for strip in [one for one in silenced if json_properties.text(one, TAG) not in used]:
            _siblings(scene, strip).remove(strip)


def _shown_elsewhere(armature: ArmatureObject) -> set[str]:
    """Return the tags of the shown takes of all other characters."""
    others = [item.s2ag for item in bpy.data.objects if is_armature(item) and item != armature]
    shown = [one.takes[one.active_take].action for one in others if 0 <= one.active_take < len(one.takes)]
    return {json_properties.text(action, TAG) for action in shown if action is not None}
