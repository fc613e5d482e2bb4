"""Every difference between Blender 4.2, 4.5, 5.0 and 5.2 that this package meets. Nothing else asks for a version."""

import bpy


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


def strip_start(strip) -> float:
    """The scene frame of a strip's first content frame."""
    return strip.content_start if hasattr(strip, "content_start") else strip.frame_start


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
