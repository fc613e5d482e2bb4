"""The sound strip of a run: made by it, known to its takes, heard while one of them is shown.

A strip of ours carries a tag that its takes know, too. Strips of the user have none and are never touched.
"""

import uuid

import bpy

from .. import compat
from ..datablocks import ArmatureObject, SoundStrip
from ..film import sound
from ..keys.layers import Place
from ..translations import told

TAG = "s2ag_voice"
"""Custom property of a strip of ours, and of the actions of the takes that it belongs to."""
_SILENCED = "s2ag_silenced"  # on strips that were muted here, not by the user


def lay(scene: bpy.types.Scene, path: str, start: int, name: str, wanted: bool = True) -> tuple[str, list[str]]:
    """The tag of the strip that plays a recording from a frame on, made if ``wanted``; and what the user should know.

    The tag is empty where the strip is the user's or there is none. Raises :class:`AudioUnreadable`.
    """
    others = [strip for strip in sound.of_file(scene, path) if TAG not in strip]
    strip = sound.playing(scene, path, start)
    if strip is None and not wanted:
        return "", []
    if strip is None:
        strip = sound.add_sound(scene, path, start, name)
        strip[TAG] = uuid.uuid4().hex
        compat.show_in_sequencers(scene)
    scene.sync_mode = "AUDIO_SYNC" if wanted else scene.sync_mode
    twice = [other for other in others if other != strip and not other.mute]
    said = [(one.name, round(compat.strip_start(one))) for one in twice]
    return strip.get(TAG, ""), [
        told('Your strip "{name}" plays this recording at frame {frame}, too.', name=name, frame=frame) for name, frame in said
    ]


def reload(sound: bpy.types.Sound) -> None:
    """Let a sound be what its file holds by now."""
    if sound.packed_file is None and sound.library is None:
        sound.filepath = sound.filepath  # Blender reads a file again when it is named


def renewed(scene: bpy.types.Scene, strip: SoundStrip):
    """A strip of ours anew, as long as the sound that it was given; a strip keeps its length whatever it is given."""
    if TAG not in strip:
        return strip
    strips = compat.sequencer_strips(strip.parent_meta() or scene.sequence_editor)
    kept = {name: getattr(strip, name) for name in ("name", "mute", "volume", "channel")}
    path, start, tag = bpy.path.abspath(strip.sound.filepath), round(compat.strip_start(strip)), strip[TAG]
    strips.remove(strip)
    made = strips.new_sound(kept["name"], path, kept["channel"], start)
    for name, value in kept.items():
        setattr(made, name, value)
    made[TAG] = tag
    return made


def hear(armature: ArmatureObject, action: bpy.types.Action) -> list[str]:
    """Let the strip of the take that is shown be heard in place of those of the character's other takes on its frames.

    Returns the names of strips that are silent from now on. Strips of the user and of other characters' takes stay.
    """
    place, shown = Place.of(action), action.get(TAG, "")
    if place is None:
        return []
    mine = {take.action.get(TAG, "") for take in armature.s2ag.takes if take.action is not None}
    mine -= {shown, *_shown_elsewhere(armature)}
    silenced = []
    for strip in _ours():
        if strip[TAG] == shown:
            if strip.get(_SILENCED):
                strip.mute = False
                del strip[_SILENCED]
        elif strip[TAG] in mine and not strip.mute and place.overlaps(*_frames(strip)):
            strip.mute = strip[_SILENCED] = True
            silenced.append(strip.name)
    return silenced


def clear() -> None:
    """Remove silent strips of ours that no take has any more."""
    used = {action.get(TAG, "") for action in bpy.data.actions}
    for scene in bpy.data.scenes:
        for strip in [one for one in compat.sound_strips(scene) if one.get(_SILENCED) and one.get(TAG) not in used]:
            owner = strip.parent_meta() or scene.sequence_editor
            compat.sequencer_strips(owner).remove(strip)


def _ours() -> list:
    return [strip for scene in bpy.data.scenes for strip in compat.sound_strips(scene) if TAG in strip]


def _shown_elsewhere(armature: ArmatureObject) -> set[str]:
    others = [item.s2ag for item in bpy.data.objects if item.type == "ARMATURE" and item != armature]
    shown = [one.takes[one.active_take].action for one in others if 0 <= one.active_take < len(one.takes)]
    return {action.get(TAG, "") for action in shown if action is not None}


def _frames(strip: SoundStrip) -> tuple[int, int]:
    return round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
