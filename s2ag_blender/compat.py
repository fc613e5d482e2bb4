"""Bridges every difference between Blender 4.2, 4.5, 5.0 and 5.2 that this package meets; no other module checks versions."""
# pyright: reportAttributeAccessIssue=false
# The stubs know one version of Blender; half the names below belong to another.

import os
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any, Literal, cast

import bpy

from .datablocks import ArmatureObject, Bag, Slot, SoundStrip

RELATIVE: Any = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else set()
"""Options of a path property whose value may be relative to the .blend ("//...")."""
PICTURES_STAY = {"export_textures_mode": "KEEP"} if bpy.app.version >= (4, 5) else {"export_textures": False}
"""Arguments with which the USD exporter writes no images."""

_STALL_SECONDS = 5.0
"""A file that has not grown for so many seconds is taken as complete."""


def selected_bones(armature: ArmatureObject) -> list[str]:
    """Return the names of the bones that are selected in pose mode, parents first."""
    selected = {bone.name for bone in _selectable(armature) if bone.select}
    return [bone.name for bone in armature.data.bones if bone.name in selected]


def select_bones(armature: ArmatureObject, names: Collection[str]) -> None:
    """Select these bones in pose mode and no other."""
    for bone in _selectable(armature):
        bone.select = bone.name in names


def _selectable(armature: ArmatureObject) -> Any:
    """Return the bones that carry the selection of pose mode: since 5.0 pose bones, before the armature's bones."""
    return (armature.pose if "select" in bpy.types.PoseBone.bl_rna.properties else armature.data).bones


def new_action(name: str, datablock: bpy.types.ID) -> tuple[bpy.types.Action, Slot | None, Bag]:
    """Create an action for ``datablock``; return ``(action, slot or None, bag)``, the bag holding its F-curves and groups.

    Since 4.4 an action has slots, layers and a channel bag for each slot; before, the action itself is the bag."""
    action = bpy.data.actions.new(name)
    if not hasattr(action, "slots"):
        action.id_root = "OBJECT"
        return action, None, cast(Bag, action)
    slot = action.slots.new(id_type="OBJECT", name=datablock.name)
    strip = action.layers.new("Layer").strips.new(type="KEYFRAME")
    return action, slot, strip.channelbag(slot, ensure=True)


def copy_action(action: bpy.types.Action, slot: Slot | None, name: str) -> tuple[bpy.types.Action, Slot | None, Bag]:
    """Copy an action under a new name; return ``(action, slot or None, bag)`` like :func:`new_action`.

    The copy uses the slot with the identifier of ``slot``, or a new slot where there is none."""
    copy = action.copy()
    copy.name = name
    copy.asset_clear()
    if not hasattr(copy, "slots"):
        return copy, None, cast(Bag, copy)
    twin = copy.slots.get(slot.identifier) if slot is not None else None
    twin = twin or copy.slots.new(id_type="OBJECT", name="Gestures")
    layer = copy.layers[0] if copy.layers else copy.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return copy, twin, strip.channelbag(twin, ensure=True)


def key_bag(action: bpy.types.Action, key: bpy.types.Key) -> tuple[bpy.types.Action, Slot | None, Bag]:
    """Return ``(action, slot or None, bag)`` for the F-curves of a mesh's shape keys that belong to a body's ``action``.

    With slots it is the same action with one more slot, before 4.4 a new action."""
    if not hasattr(action, "slots"):
        own = bpy.data.actions.new(action.name)
        own.id_root = "KEY"
        return own, None, cast(Bag, own)
    slot = action.slots.new(id_type="KEY", name=key.name)
    return action, slot, action.layers[0].strips[0].channelbag(slot, ensure=True)


def bag(action: bpy.types.Action, slot: Slot | None = None) -> Bag:
    """Return the bag with the F-curves and groups of an action's ``slot`` (the first slot, if None)."""
    if not hasattr(action, "slots"):
        return cast(Bag, action)
    return action.layers[0].strips[0].channelbag(slot or action.slots[0], ensure=True)


def slot_name(slot: Slot | None) -> str:
    """Return the identifier by which :func:`find_slot` finds a slot again; empty where there are no slots."""
    return slot.identifier if slot is not None else ""


def temporary_folder() -> Path:
    """Return Blender's temporary folder, which is made again where others have deleted it."""
    folder = Path(bpy.app.tempdir)
    folder.mkdir(0o700, parents=True, exist_ok=True)
    return folder


def find_slot(action: bpy.types.Action, name: str) -> Slot | None:
    """Return the slot of an action with the identifier ``name`` (see :func:`slot_name`), or None."""
    return action.slots.get(name) if name and isinstance(name, str) and hasattr(action, "slots") else None


def first_slot(action: bpy.types.Action, name: str = "") -> Slot | None:
    """Return the slot of an action for the object called ``name``, else its first; None where there are none."""
    slots = getattr(action, "slots", ())
    return next((slot for slot in slots if slot.name_display == name), slots[0] if slots else None)


def active_slot(datablock: bpy.types.ID) -> Slot | None:
    """Return the slot of the active action that animates ``datablock``, or None."""
    return getattr(datablock.animation_data, "action_slot", None)


def assign_action(datablock: bpy.types.ID, action: bpy.types.Action | None, slot: Slot | None = None) -> None:
    """Make ``action`` (None for none) the active action of ``datablock``, through ``slot`` where there are slots."""
    animation = datablock.animation_data_create()
    animation.action = action
    if slot is not None:
        animation.action_slot = slot


def strip_slot(strip: bpy.types.NlaStrip, slot: Slot | None) -> None:
    """Make an NLA strip play ``slot`` of its action."""
    if slot is not None:
        strip.action_slot = slot


def strip_curve(strip: bpy.types.NlaStrip, name: str) -> bpy.types.FCurve | None:
    """Return the F-curve of an NLA strip's own property, such as its influence, or None."""
    return strip.fcurves.find(name)


def curves(action: bpy.types.Action, slot: Slot | None = None) -> list[bpy.types.FCurve]:
    """Return the F-curves of an action's ``slot``, of all slots if None."""
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


def sequencer_strips(editor: bpy.types.SequenceEditor) -> Any:
    """Return the top-level strips of a sequence editor."""
    return editor.strips if hasattr(editor, "strips") else editor.sequences


def sound_strips(scene: bpy.types.Scene) -> list[SoundStrip]:
    """Return all sound strips of a scene's sequencer, those within meta strips included."""
    editor = scene.sequence_editor
    if editor is None:
        return []
    strips: Any = editor.strips_all if hasattr(editor, "strips_all") else editor.sequences_all
    return [strip for strip in strips if strip.type == "SOUND"]


def mixdown(scene: bpy.types.Scene, path: str | Path, bits: Literal["S16", "S32"]) -> None:
    """Write the sound of a scene's sequencer as a WAV of the sample format ``bits``; the file is complete on return.

    With a window, Blender 5.2 writes in the background and this waits for it. Raises :class:`RuntimeError` if nothing
    is written."""
    with bpy.context.temp_override(scene=scene):
        bpy.ops.sound.mixdown(filepath=str(path), container="WAV", codec="PCM", format=bits, check_existing=False)
    size, since = -1, time.monotonic()
    while not bpy.app.background and not _whole(path):
        now = os.path.getsize(path) if os.path.exists(path) else 0
        size, since = now, since if now == size else time.monotonic()
        if time.monotonic() - since > _STALL_SECONDS and now > 0:
            return
        if time.monotonic() - since > _STALL_SECONDS:
            raise RuntimeError("nothing was written")
        time.sleep(0.02)


def _whole(path: str | Path) -> bool:
    """Return whether a WAV is as long as its header says; Blender writes the header last."""
    try:
        with open(path, "rb") as file:
            header = file.read(8)
        return len(header) == 8 and int.from_bytes(header[4:], "little") + 8 == os.path.getsize(path)
    except OSError:  # not there yet
        return False


def show_in_sequencers(scene: bpy.types.Scene) -> None:
    """Show this scene in sequencers that show none: since Blender 5.0 a workspace starts without a sequencer scene."""
    for workspace in bpy.data.workspaces:
        if getattr(workspace, "sequencer_scene", scene) is None:
            workspace.sequencer_scene = scene


def visible_start(strip: SoundStrip) -> float:
    """Return the scene frame of a strip's first visible frame."""
    return strip.left_handle if hasattr(strip, "left_handle") else strip.frame_final_start


def strip_start(strip: SoundStrip) -> float:
    """Return the scene frame at which a strip's content starts, its trimmed part included."""
    return strip.content_start if hasattr(strip, "content_start") else strip.frame_start


def strip_length(strip: SoundStrip) -> float:
    """Return the length of a strip's content in scene frames, its trimmed parts included."""
    return strip.content_duration if hasattr(strip, "content_duration") else strip.frame_duration


def retiming_frames(strip: SoundStrip) -> list[float]:
    """Return the scene frames of a strip's retiming keys; none where it plays at its own speed."""
    return [key.timeline_frame for key in getattr(strip, "retiming_keys", ())]


def move_strip(strip: SoundStrip, frame: float) -> None:
    """Move a strip so that its content starts at ``frame``."""
    if hasattr(strip, "content_start"):
        strip.content_start = frame
    else:
        strip.frame_start = frame


def strip_end(strip: SoundStrip) -> float:
    """Return the scene frame after a strip's last visible one."""
    return strip.right_handle if hasattr(strip, "right_handle") else strip.frame_final_end


def compositing(scene: Any) -> bpy.types.NodeTree | None:
    """Return the compositor's nodes that renders pass through."""
    if hasattr(scene, "compositing_node_group"):  # since 5.0
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def eevee() -> str:
    """Return the identifier of the Eevee render engine."""
    return "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0) else "BLENDER_EEVEE"


def set_video(settings: bpy.types.ImageFormatSettings) -> None:
    """Set render output to video by FFmpeg."""
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"


def set_image(settings: bpy.types.ImageFormatSettings, file_format: str = "PNG") -> None:
    """Set render output to single images of ``file_format``."""
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = file_format


def plain_path(path: str | Path) -> str:
    """Return a path for render output with braces escaped: since 4.5 they mark templates unless they are doubled."""
    text = str(path)
    return text if bpy.app.version < (4, 5) else text.replace("{", "{{").replace("}", "}}")


def stored(datablock: bpy.types.ID | bpy.types.Bone, name: str) -> Any:
    """Return an add-on's data on a datablock or bone: its registered property group, else their raw data, else None.

    Since 5.0 registered properties are stored apart from custom properties, hidden where the add-on is not installed."""
    if (registered := getattr(datablock, name, None)) is not None:
        return registered
    if name in datablock:
        return datablock[name]
    if not hasattr(datablock, "bl_system_properties_get"):
        return None
    return (datablock.bl_system_properties_get() or {}).get(name)
