"""Every difference between Blender 4.2, 4.5, 5.0 and 5.2 that this package meets. Nothing else asks for a version."""

import os
import time
from pathlib import Path

import bpy

RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else set()
"""Options of a path property that may start with "//"."""
PICTURES_STAY = {"export_textures_mode": "KEEP"} if bpy.app.version >= (4, 5) else {"export_textures": False}
"""What the USD exporter is told so that it writes no pictures."""

_PATIENCE = 5.0
"""Seconds without another byte after which nothing more is waited for."""


def selected_bones(armature: bpy.types.Object) -> list[str]:
    """Names of the bones that are selected in pose mode, parents first."""
    selected = {bone.name for bone in _selectable(armature) if bone.select}
    return [bone.name for bone in armature.data.bones if bone.name in selected]


def select_bones(armature: bpy.types.Object, names) -> None:
    """Select these bones in pose mode and no other."""
    for bone in _selectable(armature):
        bone.select = bone.name in names


def _selectable(armature: bpy.types.Object):
    """What is selected in pose mode: since 5.0 the bones of the pose, before those of the armature."""
    return (armature.pose if "select" in bpy.types.PoseBone.bl_rna.properties else armature.data).bones


def new_action(name: str, datablock: bpy.types.ID):
    """A new action for ``datablock`` and what its curves and groups go into: ``(action, slot or None, bag)``.

    Since 4.4 an action holds slots, layers and a channel bag for each slot; before, it was the bag itself.
    """
    action = bpy.data.actions.new(name)
    if not hasattr(action, "slots"):
        action.id_root = "OBJECT"
        return action, None, action
    slot = action.slots.new(id_type="OBJECT", name=datablock.name)
    strip = action.layers.new("Layer").strips.new(type="KEYFRAME")
    return action, slot, strip.channelbag(slot, ensure=True)


def copy_action(action: bpy.types.Action, slot, name: str):
    """A copy of an action under a new name, as :func:`new_action` gives one: ``(action, slot or None, bag)``.

    The slot of the copy is the one of the same identifier; without one that has curves, it gets one of its own.
    """
    copy = action.copy()
    copy.name = name
    copy.asset_clear()
    if not hasattr(copy, "slots"):
        return copy, None, copy
    twin = copy.slots.get(slot.identifier) if slot is not None else None
    twin = twin or copy.slots.new(id_type="OBJECT", name="Gestures")
    layer = copy.layers[0] if copy.layers else copy.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return copy, twin, strip.channelbag(twin, ensure=True)


def key_bag(action: bpy.types.Action, key: bpy.types.Key):
    """What the curves of a mesh's shape keys go into, beside those of a body's action: ``(action, slot or None, bag)``.

    With slots it is the same action, before 4.4 another one.
    """
    if not hasattr(action, "slots"):
        own = bpy.data.actions.new(action.name)
        own.id_root = "KEY"
        return own, None, own
    slot = action.slots.new(id_type="KEY", name=key.name)
    return action, slot, action.layers[0].strips[0].channelbag(slot, ensure=True)


def bag(action: bpy.types.Action, slot=None):
    """What holds the curves and groups of an action's slot (of its first one, if None)."""
    if not hasattr(action, "slots"):
        return action
    return action.layers[0].strips[0].channelbag(slot or action.slots[0], ensure=True)


def slot_name(slot) -> str:
    """What a slot is found again by; empty where there are no slots."""
    return slot.identifier if slot is not None else ""


def find_slot(action: bpy.types.Action, name: str):
    """The slot of an action that :func:`slot_name` told of, or None."""
    return action.slots.get(name) if name and hasattr(action, "slots") else None


def first_slot(action: bpy.types.Action, name: str = ""):
    """The slot of an action for the object called ``name``, else its first; None where there are none."""
    slots = getattr(action, "slots", ())
    return next((slot for slot in slots if slot.name_display == name), slots[0] if slots else None)


def active_slot(datablock: bpy.types.ID):
    """The slot that ``datablock`` plays of its active action, or None."""
    return getattr(datablock.animation_data, "action_slot", None)


def assign_action(datablock: bpy.types.ID, action: bpy.types.Action, slot=None) -> None:
    """Make ``action`` the active action of ``datablock``, through ``slot`` where there are slots."""
    animation = datablock.animation_data_create()
    animation.action = action
    if slot is not None:
        animation.action_slot = slot


def strip_slot(strip: bpy.types.NlaStrip, slot) -> None:
    """Let an NLA strip play ``slot`` of its action."""
    if slot is not None:
        strip.action_slot = slot


def strip_curve(strip: bpy.types.NlaStrip, name: str):
    """The curve of an NLA strip's own property, or None."""
    return strip.fcurves.find(name)


def curves(action: bpy.types.Action, slot=None) -> list:
    """The curves of an action, or of one of its slots; of all slots when ``slot`` is None."""
    if not hasattr(action, "slots"):
        return list(action.fcurves)
    return [
        curve
        for layer in action.layers
        for strip in layer.strips
        for one in ([slot] if slot is not None else action.slots)
        if (bag := strip.channelbag(one)) is not None
        for curve in bag.fcurves
    ]


def sequencer_strips(editor):
    """The top-level strips of a sequence editor."""
    return editor.strips if hasattr(editor, "strips") else editor.sequences


def sound_strips(scene: bpy.types.Scene) -> list:
    """All sound strips of a scene's sequencer, also those within meta strips; none without a sequencer."""
    editor = scene.sequence_editor
    if editor is None:
        return []
    strips = editor.strips_all if hasattr(editor, "strips_all") else editor.sequences_all
    return [strip for strip in strips if strip.type == "SOUND"]


def mixdown(scene: bpy.types.Scene, path: str | Path, bits: str) -> None:
    """Write what a scene's sequencer plays as a WAV of ``bits`` ("S16", "S32"); it is whole when this returns.

    With a window Blender 5.2 writes it beside its other work, and only begins here. Raises :class:`RuntimeError`.
    """
    with bpy.context.temp_override(scene=scene):
        bpy.ops.sound.mixdown(filepath=str(path), container="WAV", codec="PCM", format=bits, check_existing=False)
    size, since = -1, time.monotonic()
    while not bpy.app.background and not _whole(path):
        now = os.path.getsize(path) if os.path.exists(path) else 0
        size, since = now, since if now == size else time.monotonic()
        if time.monotonic() - since > _PATIENCE and now > 0:
            return
        if time.monotonic() - since > _PATIENCE:
            raise RuntimeError("nothing was written")
        time.sleep(0.02)


def _whole(path: str | Path) -> bool:
    """Whether a WAV is as long as its head says, which is written last."""
    try:
        with open(path, "rb") as file:
            head = file.read(8)
        return len(head) == 8 and int.from_bytes(head[4:], "little") + 8 == os.path.getsize(path)
    except OSError:  # not there yet
        return False


def show_in_sequencers(scene: bpy.types.Scene) -> None:
    """Let sequencers that show no scene yet show this one: since Blender 5.0 a workspace has none at first."""
    for workspace in bpy.data.workspaces:
        if getattr(workspace, "sequencer_scene", scene) is None:
            workspace.sequencer_scene = scene


def visible_start(strip) -> float:
    """The scene frame of a strip's first visible frame."""
    return strip.left_handle if hasattr(strip, "left_handle") else strip.frame_final_start


def strip_start(strip) -> float:
    """The scene frame of a strip's first content frame."""
    return strip.content_start if hasattr(strip, "content_start") else strip.frame_start


def strip_length(strip) -> float:
    """Scene frames of all that a strip plays, whatever is cut off."""
    return strip.content_duration if hasattr(strip, "content_duration") else strip.frame_duration


def retiming_frames(strip) -> list[float]:
    """The scene frames of a strip's retiming keys; none where it plays at its own speed."""
    return [key.timeline_frame for key in getattr(strip, "retiming_keys", ())]


def move_strip(strip, frame: float) -> None:
    """Move a strip so that its content starts at ``frame``."""
    if hasattr(strip, "content_start"):
        strip.content_start = frame
    else:
        strip.frame_start = frame


def strip_end(strip) -> float:
    """The scene frame after a strip's last one."""
    return strip.right_handle if hasattr(strip, "right_handle") else strip.frame_final_end


def eevee() -> str:
    """The identifier of the Eevee engine."""
    return "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0) else "BLENDER_EEVEE"


def set_video(settings: bpy.types.ImageFormatSettings) -> None:
    """Make render output a film through FFmpeg."""
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"


def set_image(settings: bpy.types.ImageFormatSettings, file_format: str = "PNG") -> None:
    """Make render output single images."""
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = file_format


def plain_path(path) -> str:
    """A path for render output as it is: since 4.5 braces in it are templates unless they are doubled."""
    text = str(path)
    return text if bpy.app.version < (4, 5) else text.replace("{", "{{").replace("}", "}}")


def stored(datablock, name: str):
    """What an add-on keeps on a datablock or bone: its registered properties, else their plain data, else None.

    Since 5.0 registered properties are kept apart from the user's own, out of sight where the add-on is not installed.
    """
    if (registered := getattr(datablock, name, None)) is not None:
        return registered
    if name in datablock:
        return datablock[name]
    if not hasattr(datablock, "bl_system_properties_get"):
        return None
    return (datablock.bl_system_properties_get() or {}).get(name)
