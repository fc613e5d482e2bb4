"""Property groups: the settings of a character, stored on its armature object and saved with the file, and its takes."""
# pyright: reportInvalidTypeForm=false, reportArgumentType=false
# Callbacks of properties get the context as our own subtype.

from typing import Any

import bpy

from .. import compat
from ..datablocks import Context, current_context
from ..rig import readiness
from ..takes import gesture_edits, menu_items, preview, take_list
from ..takes.menu_items import control_names, style_names
from ..takes.operator_base import character
from .curve_properties import EDITABLE, CurveSettings, update_preview
from .setting_properties import SettingProperties

__all__ = ["S2AG_BoneChoice", "S2AG_Session", "S2AG_Settings", "S2AG_Take", "S2AG_Version", "control_names", "style_names"]

PARTS = (
    ("TORSO", "Torso", "Key the spine"),
    ("HEAD", "Head", "Key neck and head"),
    ("CLAVICLES", "Clavicles", "Key both shoulders"),
    ("LEFT_ARM", "Left Arm", "Key the left upper arm and forearm"),
    ("RIGHT_ARM", "Right Arm", "Key the right upper arm and forearm"),
)


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


def _on_title(take: Any, context: Context) -> None:
    take_list.rename(take.id_data, take)


def _on_keep(take: Any, context: Context) -> None:
    if take.action is not None and take.keep:
        take.action.use_fake_user = True


def _on_bones(item: Any, context: Context) -> None:
    readiness.clear_cache(item.id_data)


_PARTNER = "Another character, or what stands for one: it is looked at, and listened to while it speaks"


def _factor(name: str, description: str, default: float, high: float = 1.5, update: Any = None) -> Any:
    """Return a float property from 0 to ``high``."""
    return bpy.props.FloatProperty(
        name=name, description=description, default=default, min=0.0, max=high, precision=2, override=EDITABLE, update=update,
        subtype="FACTOR",
    )


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


class S2AG_Settings(SettingProperties, CurveSettings, bpy.types.PropertyGroup):
    """All settings of a character: those of the engine (:mod:`core.settings`), and those of Blender alone."""

    audio_source: bpy.props.EnumProperty(
        name="Voice",
        description="Where the voice is",
        items=[
            ("FILE", "File", "A recording on disk"),
            ("STRIP", "Strip", "A sound strip of the sequencer, in sync with it"),
            ("MIXDOWN", "Sequencer", "All that the sequencer plays in the range"),
        ],
        override=EDITABLE,
    )
    audio: bpy.props.StringProperty(
        name="Recording",
        description="Voice recording, in any common format",
        subtype="FILE_PATH",
        options=compat.RELATIVE,
        override=EDITABLE,
    )
    sound_strip: bpy.props.StringProperty(
        name="Sound Strip",
        description="Sound strip of this scene's sequencer to gesture to",
        search=menu_items.search_strips,
        override=EDITABLE,
    )
    transcript_source: bpy.props.EnumProperty(
        name="Words",
        description="Where the words of the recording are; with words, gestures follow their meaning",
        items=[
            ("FILE", "File", "A transcript of any form; if none is named, the one beside the recording, by the same name"),
            ("BLOCK", "Text Block", "A text of this file, as the text editor shows it"),
            ("TYPED", "Typed", "Words typed here"),
            ("NONE", "None", "The audio alone gestures"),
            ("RECOGNISE", "Recognize", "What the engine's speech recognizer hears in the recording, in English"),
        ],
        override=EDITABLE,
    )
    transcript_block: bpy.props.PointerProperty(
        type=bpy.types.Text, name="Text Block", description="Text with the words of the recording", override=EDITABLE
    )
    typed: bpy.props.StringProperty(name="Typed Words", description="What is said in the recording", override=EDITABLE)

    style_pick: bpy.props.EnumProperty(
        name="Style",
        description="Whose manner of gesturing to take on",
        items=menu_items.style_items,
        get=menu_items.get_style,
        set=menu_items.set_style,
        options={"SKIP_SAVE"},
    )
    style_second: bpy.props.StringProperty(
        name="Second Style", description="Name of the style that is blended in", override=EDITABLE, update=update_preview
    )
    style_second_pick: bpy.props.EnumProperty(
        name="Blend With",
        description="A second style to blend in",
        items=menu_items.second_items,
        get=menu_items.get_second,
        set=menu_items.set_second,
        options={"SKIP_SAVE"},
    )
    style_mix: bpy.props.FloatProperty(
        name="Amount",
        description="How much of the second style: 0 is the first style, 1 the second",
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        override=EDITABLE,
        update=update_preview,
    )
    partner: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Talks With", description=_PARTNER, override=EDITABLE, update=update_preview
    )

    range: bpy.props.EnumProperty(
        name="Frames",
        description="Frames that may be keyed, and where the recording starts",
        items=[
            ("OWN", "From Frame", "The whole recording, from a frame on"),
            ("SCENE", "Scene", "The recording starts with the scene and is cut where the scene ends"),
            ("PREVIEW", "Preview", "What the sequencer plays of the recording in that range; else the recording starts there"),
            ("STRIP", "Strip", "The frames that the sound strip covers, in sync with it"),
        ],
        override=EDITABLE,
        update=update_preview,
    )
    start_frame: bpy.props.IntProperty(
        name="Start Frame",
        description="Frame on which the recording starts",
        default=1,
        subtype="TIME",
        override=EDITABLE,
        update=update_preview,
    )
    result: bpy.props.EnumProperty(
        name="Result",
        description="How gestures meet the animation that is there; existing actions are never changed",
        items=[
            ("ACTION", "Action", "A new active action: the former one's copy with gestures in the range"),
            ("STRIP", "Strip", "An NLA strip over the animation that is there"),
            ("LAYER", "Layer", "An NLA strip that adds gestures to the animation that is there"),
        ],
        override=EDITABLE,
        update=update_preview,
    )
    influence: _factor("Influence", "How much of the strip or layer is seen", 1.0, 1.0, update=update_preview)
    blend_in: bpy.props.IntProperty(
        name="Blend In",
        description="Frames over which the animation that is there turns into gestures",
        default=8,
        min=0,
        soft_max=48,
        subtype="TIME",
        override=EDITABLE,
        update=update_preview,
    )
    blend_out: bpy.props.IntProperty(
        name="Blend Out",
        description="Frames over which gestures turn back into the animation that is there",
        default=8,
        min=0,
        soft_max=48,
        subtype="TIME",
        override=EDITABLE,
        update=update_preview,
    )
    start_pose: bpy.props.EnumProperty(
        name="Start",
        description="The pose that gestures grow out of",
        items=[
            ("REST", "At Ease", "The speaker's own way of standing"),
            ("CURRENT", "This Pose", "Continue from the pose that the character has now"),
        ],
        override=EDITABLE,
        update=update_preview,
    )
    end_pose: bpy.props.EnumProperty(
        name="End",
        description="The pose that gestures lead to",
        items=[
            ("FREE", "Free", "Wherever the gestures end"),
            ("CURRENT", "This Pose", "Reach the pose that the character has now"),
            ("THERE", "Pose There", "Reach the pose that the character's animation has on the last frame"),
        ],
        override=EDITABLE,
        update=update_preview,
    )
    add_sound: bpy.props.BoolProperty(
        name="Sound Strip", description="Put the recording into the sequencer", default=True, override=EDITABLE
    )
    add_markers: bpy.props.BoolProperty(
        name="Word Markers", description="Put a timeline marker on every word", override=EDITABLE
    )
    marker_prefix: bpy.props.StringProperty(
        name="Marker Prefix",
        description="What the names of word markers start with; by it they are found again and removed",
        default="w:",
        override=EDITABLE,
    )

    torso_strength: _factor("Torso", "How much the spine takes part", 1.0, update=update_preview)
    head_strength: _factor("Head", "How much neck and head take part", 1.0, update=update_preview)
    clavicle_strength: _factor("Clavicles", "How much the shoulders take part", 0.6, update=update_preview)
    palms: _factor("Palms", "How far forearms turn the palms inwards and down", 0.4, 1.0, update=update_preview)
    parts: bpy.props.EnumProperty(
        name="Parts",
        description="Parts of the body that are keyed; the others keep what they have",
        items=PARTS,
        options={"ENUM_FLAG"},
        default={part for part, _, _ in PARTS},
        override=EDITABLE,
        update=update_preview,
    )
    target: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Object", description="What a hand holds or points at", override=EDITABLE
    )
    bone_map: bpy.props.CollectionProperty(
        type=S2AG_BoneChoice,
        name="Bone Map",
        description="Bones chosen by hand; empty for those that were found",
        override={"LIBRARY_OVERRIDABLE", "USE_INSERTION"},
    )
    bone_map_notes: bpy.props.StringProperty(
        name="Bone Map Notes",
        description="What a loaded bone map says besides its bones: kind of rig and switches, as JSON",
        options={"HIDDEN"},
        override=EDITABLE,
    )
    takes: bpy.props.CollectionProperty(
        type=S2AG_Take, name="Takes", description="Takes of this character", override={"LIBRARY_OVERRIDABLE", "USE_INSERTION"}
    )
    active_take: bpy.props.IntProperty(
        name="Take", description="The take that the character plays", default=-1, override=EDITABLE, update=_on_active_take
    )
