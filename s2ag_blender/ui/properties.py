"""Property groups: the settings of a character, stored on its armature object and saved with the file, and its takes."""
# pyright: reportInvalidTypeForm=false, reportArgumentType=false
# Callbacks of properties get the context as our own subtype.

from typing import Any, cast

import bpy

from ..datablocks import Context, current_context
from ..rig import readiness
from ..takes import gesture_edits, menu_items, preview, take_list
from ..takes.menu_items import control_names, style_names
from ..takes.operator_base import character
from .setting_properties import EDITABLE, SettingProperties, update_preview

__all__ = ["S2AG_BoneChoice", "S2AG_Session", "S2AG_Settings", "S2AG_Take", "S2AG_Version", "control_names", "style_names"]


def _on_live(settings: Any, context: Context) -> None:
    preview.preview_switched(context)


def _on_active_take(settings: Any, context: Context) -> None:
    take_list.show(settings.id_data)


def _get_gesture(session: Any) -> int:
    context = current_context()
    return gesture_edits.marker_row(character(context), context.scene)


def _set_gesture(session: Any, row: int) -> None:
    context = current_context()
    gesture_edits.go_to(character(context), context.scene, row)
    bpy.ops.ed.undo_push(message="Change Frame")  # as scrubbing does: undoing an edit leaves the playhead at its gesture


def _on_title(take: Any, context: Context) -> None:
    take_list.rename(take.id_data, take)


def _on_keep(take: Any, context: Context) -> None:
    if take.action is not None and take.keep:
        take.action.use_fake_user = True


def _on_bones(item: Any, context: Context) -> None:
    readiness.clear_cache(item.id_data)


def _action() -> Any:
    about = "The action that holds its keys"
    return bpy.props.PointerProperty(type=bpy.types.Action, name="Action", description=about, override=EDITABLE)


class S2AG_BoneChoice(bpy.types.PropertyGroup):
    """Bones that the user chose for a part of the body; ``name`` is the part."""

    bones: bpy.props.StringProperty(
        name="Bones",
        description="Bones that carry this part, from the lowest to the highest, with commas between; empty leaves it out",
        search=menu_items.search_bones,
        search_options={"SUGGESTION"},
        override=EDITABLE,
        update=_on_bones,
    )


class S2AG_Version(bpy.types.PropertyGroup):
    """A take after one of its edits; ``name`` is its number."""

    action: _action()
    warnings: bpy.props.StringProperty(options={"HIDDEN"}, override=EDITABLE)  # one per line
    title: bpy.props.StringProperty(options={"HIDDEN"}, override=EDITABLE)  # what it did


class S2AG_Take(bpy.types.PropertyGroup):
    """A take of a character; its provenance is stored on its action. ``name`` is its number, which is never reused."""

    title: bpy.props.StringProperty(name="Title", description="What this take is called", override=EDITABLE, update=_on_title)
    action: _action()
    keep: bpy.props.BoolProperty(
        name="Keep", description="Spare this take when the others are deleted", override=EDITABLE, update=_on_keep
    )
    run: bpy.props.IntProperty(options={"HIDDEN"}, override=EDITABLE)  # the same for all takes of one press of the button
    recording: bpy.props.StringProperty(options={"HIDDEN"}, override=EDITABLE)
    warnings: bpy.props.StringProperty(options={"HIDDEN"}, override=EDITABLE)  # one per line
    first: bpy.props.IntProperty(options={"HIDDEN"}, override=EDITABLE)
    last: bpy.props.IntProperty(options={"HIDDEN"}, override=EDITABLE)
    versions: bpy.props.CollectionProperty(
        type=S2AG_Version,
        name="Versions",
        description="What this take was before its edits, and what else it could be",
        override={"LIBRARY_OVERRIDABLE", "USE_INSERTION"},
    )


class S2AG_Session(bpy.types.PropertyGroup):
    """State of this Blender session, which is not saved in files."""

    live: bpy.props.BoolProperty(
        name="Live Preview",
        description="Show a draft while sliders move; nothing is kept until gestures are generated",
        update=_on_live,
        options={"SKIP_SAVE"},
    )
    gesture: bpy.props.IntProperty(
        name="Gesture", description="The gesture at the playhead; choose one to go there", get=_get_gesture, set=_set_gesture
    )

    @property
    def settings(self) -> Any:
        """Settings of the active character, which presets set; None without one."""
        armature = character(current_context())
        return None if armature is None else armature.s2ag


class S2AG_Settings(SettingProperties, bpy.types.PropertyGroup):
    """All settings of a character: those of both tables, and here those that need functions or types of Blender."""

    sound_strip: bpy.props.StringProperty(
        name="Sound Strip",
        description="Sound strip of this scene's sequencer to gesture to",
        search=menu_items.search_strips,
        override=EDITABLE,
    )
    transcript_block: bpy.props.PointerProperty(
        type=bpy.types.Text, name="Text Block", description="Text with the words of the recording", override=EDITABLE
    )
    style_pick: bpy.props.EnumProperty(
        name="Style", description="Whose manner of gesturing to take on", options={"SKIP_SAVE"},
        items=menu_items.style_items, get=menu_items.get_style, set=menu_items.set_style,
    )  # fmt: skip
    style_second_pick: bpy.props.EnumProperty(
        name="Blend With", description="A second style to blend in", options={"SKIP_SAVE"},
        items=menu_items.second_items, get=menu_items.get_second, set=menu_items.set_second,
    )  # fmt: skip
    partner: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Talks With", override=EDITABLE, update=update_preview,
        description="Another character, or what stands for one: it is looked at, and listened to while it speaks",
        poll=lambda settings, item: (one := cast(Any, item)) != settings.id_data and (one.type != "MESH" or not one.parent),
    )  # fmt: skip
    target: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Object", description="What a hand holds or points at", override=EDITABLE
    )
    bone_map: bpy.props.CollectionProperty(
        type=S2AG_BoneChoice,
        name="Bone Map",
        description="Bones chosen by hand; empty for those that were found",
        override={"LIBRARY_OVERRIDABLE", "USE_INSERTION"},
    )
    takes: bpy.props.CollectionProperty(
        type=S2AG_Take, name="Takes", description="Takes of this character", override={"LIBRARY_OVERRIDABLE", "USE_INSERTION"}
    )
    active_take: bpy.props.IntProperty(
        name="Take", description="The take that the character plays", default=-1, override=EDITABLE, update=_on_active_take,
        options=set(),
    )  # fmt: skip
