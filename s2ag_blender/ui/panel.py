"""The main sidebar panel: character, recording, words, style, the button that generates gestures, and its progress."""

from typing import Any

import bpy

from ...core.worker import interpreter
from ..datablocks import ArmatureObject, Context, current_context
from ..engine import engine_state, errors_log
from ..rig import readiness
from ..takes import menu_items, preview, session, sources, take_list, versions
from ..takes.operator_base import character
from ..translations import translate
from . import presets
from .bases import Icon, LayoutMixin
from .operators import why_disabled
from .setting_properties import draw_group

_FIELD_PIXELS = 100
"""Pixels of a path that its field shows."""
_STYLE_LINES = 3
"""Lines that the sentence of a style takes at least, lest the button below it moves from style to style."""
_BUTTON_SCALE = 1.4
"""Height of the button that generates, in heights of a usual one."""


class Sidebar(LayoutMixin):
    """Base of all panels of the extension: their place in the sidebar."""

    bl_category = "Gestures"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"


class S2AG_PT_gestures(Sidebar, bpy.types.Panel):
    bl_label = "Gestures"

    def draw_header_preset(self, context: Context) -> None:
        if character(context) is not None:
            presets.S2AG_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: Context) -> None:
        layout = self.layout
        armature = character(context)
        if armature is None:
            row = layout.row()
            row.scale_y = 1.4
            row.operator("s2ag.try_it", icon="PLAY")
            layout.label(text="Select or import a character", icon="INFO")
            column = layout.column(align=True)
            column.operator("s2ag.add_human", icon="OUTLINER_OB_ARMATURE")
            column.operator("s2ag.add_mannequin", icon="ARMATURE_DATA")
            return
        settings = armature.s2ag
        layout.use_property_split = True
        layout.use_property_decorate = False
        draw_character(layout, armature)
        draw_voice(layout, settings, context.scene)
        draw_words(layout, settings, context)
        draw_style(layout, settings)
        draw_run(layout, armature, context)


def draw_character(layout: bpy.types.UILayout, armature: ArmatureObject) -> None:
    """Draw the character's name and how many of its parts were found."""
    row = layout.row()
    row.label(text=armature.name, icon="ARMATURE_DATA", translate=False)
    ready = readiness.cached(armature)
    if ready is None:
        row.label(text="Looking", icon="TIME")
    elif not ready.problem:  # a problem is shown beside the button that it greys
        icon = "CHECKMARK" if ready.found == len(ready.rows) else "INFO"
        row.label(text=translate("{found} of {all} parts", found=ready.found, all=len(ready.rows)), icon=icon)
        missing = [translate(readiness.label(row.part)) for row in ready.rows if not row.found]
        if missing:
            text = translate("Not found: {parts}. What is missing goes along with the body.", parts=", ".join(missing))
            draw_sentence(layout, text, "BLANK1")


def draw_sentence(layout: bpy.types.UILayout, text: str, icon: Icon, least: int = 1) -> None:
    """Draw a sentence wrapped into ``least`` lines or more, with an icon before the first."""
    column = layout.column(align=True)
    lines = menu_items.wrap_text(text)
    for number, line in enumerate([*lines, *[""] * (least - len(lines))]):
        column.label(text=line, icon="BLANK1" if number else icon, translate=False)


def draw_voice(layout: bpy.types.UILayout, settings: Any, scene: bpy.types.Scene) -> None:
    """Draw the settings of the recording."""
    column = layout.column()
    column.prop(settings, "audio_source")
    if settings.audio_source == "FILE":
        row = column.row(align=True)
        row.prop(settings, "audio")
        row.operator("s2ag.choose_recording", text="", icon="FILE_SOUND")
        if menu_items.text_width(settings.audio) > _FIELD_PIXELS:  # the field shows only the beginning of the path
            column.label(text=bpy.path.basename(settings.audio), icon="SOUND", translate=False)
    elif settings.audio_source == "STRIP":
        strip = sources.chosen_strip(settings, scene)
        column.prop(settings, "sound_strip", icon="SOUND")
        if strip is not None and not settings.sound_strip:
            column.label(text=translate("The only strip: {name}", name=strip.name), icon="SOUND")


def draw_words(layout: bpy.types.UILayout, settings: Any, context: Context) -> None:
    """Draw the settings of the transcript."""
    column = layout.column()
    column.prop(settings, "transcript_source")
    if settings.transcript_source == "FILE":
        transcript = "" if settings.transcript else find_transcript(settings, context.scene)
        column.prop(settings, "transcript", placeholder=bpy.path.basename(transcript))
        if not settings.transcript and not sources.missing_inputs(settings, context.scene):
            draw_found_transcript(column, transcript)
    elif settings.transcript_source == "BLOCK":
        column.prop(settings, "transcript_block")
    elif settings.transcript_source == "TYPED":
        column.prop(settings, "typed")
    elif settings.transcript_source == "RECOGNISE":
        draw_recogniser(column, context)
    if settings.transcript_source in ("BLOCK", "TYPED"):
        column.operator_menu_enum("s2ag.insert_mark", "mark", icon="ADD")


def draw_recogniser(layout: bpy.types.UILayout, context: Context) -> None:
    """Draw what the speech recogniser can do; if the engine has none, how to add one."""
    if engine_state.has_recogniser(context) is not False:
        layout.label(text="English speech only", icon="INFO")
        return
    draw_sentence(layout, translate("The engine has no speech recognizer yet"), "INFO")
    if engine_state.is_bundled(context):
        draw_sentence(
            layout, translate('In a Python of your own: pip install "s2ag[full,recognise]", then choose it'), "BLANK1"
        )
        layout.operator("s2ag.engine_choose", icon="FILE_FOLDER")
    else:
        draw_sentence(layout, translate('Add it to the engine\'s Python: pip install "s2ag[recognise]"'), "BLANK1")


def find_transcript(settings: Any, scene: bpy.types.Scene) -> str:
    """Return the path of the transcript beside the recording; empty if there is none."""
    if sources.missing_inputs(settings, scene):
        return ""
    recording = settings.audio if settings.audio_source == "FILE" else ""
    if settings.audio_source == "STRIP":
        strip = sources.chosen_strip(settings, scene)
        recording = sources.strip_path(strip) if strip is not None and strip.sound else ""
    return sources.transcript_beside(recording) or ""


def draw_found_transcript(layout: bpy.types.UILayout, transcript: str) -> None:
    """Draw which transcript was found beside the recording, if any."""
    if transcript:
        text = translate("{name} beside it has the words", name=bpy.path.basename(transcript))
        draw_sentence(layout, text, "CHECKMARK")
    else:
        draw_sentence(layout, translate("No words: the audio alone gestures"), "INFO")


def draw_style(layout: bpy.types.UILayout, settings: Any) -> None:
    """Draw the style as a menu of names with its description, and as text where it is an expression."""
    column = layout.column(align=True)
    column.prop(settings, "style_pick")
    if menu_items.is_written(settings):
        draw_group(column, settings, "performer")
    elif description := menu_items.style_description(settings):
        draw_sentence(column, translate(description), "BLANK1", _STYLE_LINES)


def draw_run(layout: bpy.types.UILayout, armature: ArmatureObject, context: Context) -> None:
    """Draw the button or the progress of a run; then the messages and warnings of the last run."""
    if engine_state.STATE.work is not None:
        draw_engine_work(layout, engine_state.STATE.work)
    elif not draw_progress(layout, armature):
        draw_button(layout, context)
    icon: Any
    for text, icon in session.messages(armature):
        draw_sentence(layout, text, icon)
    if errors_log.latest() is not None and session.messages(armature):
        layout.operator("s2ag.open_log", icon="TEXT")
    take = take_list.active(armature)
    if take is not None and versions.version_position(take)[1] < 2:
        draw_warnings(layout, take)
    draw_range_warning(layout, armature, context.scene)


def draw_warnings(layout: bpy.types.UILayout, take: Any) -> None:
    """Draw the warnings of a take; of one with versions below the buttons that flip through them, lest those jump."""
    for warning in take.warnings.splitlines():
        draw_sentence(layout, translate(warning), "ERROR")


def draw_progress(layout: bpy.types.UILayout, armature: ArmatureObject) -> bool:
    """Draw the progress of a run for this character and the button that cancels it; return whether there is a run."""
    run = session.run_of(armature)
    if run is not None:
        column = layout.column(align=True)
        row = column.row(align=True)
        row.scale_y = _BUTTON_SCALE  # as high as the button, lest all below it move under the mouse
        row.progress(factor=run.value, text=run.text)
        row.operator("s2ag.cancel", text="", icon="X")
        draw_live(column)
    return run is not None


def draw_range_warning(layout: bpy.types.UILayout, armature: ArmatureObject, scene: bpy.types.Scene) -> bool:
    """Warn, with a button that lengthens the scene, if it ends before the gestures do; return whether it does."""
    seconds = take_list.frames_beyond_scene(armature, scene)
    if seconds is None:
        return False
    gestures, end = seconds
    text = translate("Gestures until {gestures:.1f} s, scene ends at {end:.1f} s", gestures=gestures, end=end)
    draw_sentence(layout, text, "ERROR")
    layout.operator("s2ag.fit_range", icon="PREVIEW_RANGE")
    return True


def draw_button(layout: bpy.types.UILayout, context: Context) -> None:
    """Draw the button that generates, why it is greyed, and the switch of the live preview."""
    column = layout.column(align=True)
    row = column.row(align=True)
    row.scale_y = _BUTTON_SCALE
    row.operator("s2ag.generate", icon="PLAY")
    reason = why_disabled(context)
    if reason:
        draw_sentence(column, reason, "INFO")
    draw_live(column, not reason)


def draw_live(column: bpy.types.UILayout, able: bool = True) -> None:
    """Draw the switch of the live preview, greyed unless it is on or ``able`` to show anything."""
    row = column.row()
    row.enabled = able or preview.is_on()
    row.use_property_split = False  # so that the label is inside the button
    row.prop(current_context().window_manager.s2ag, "live", toggle=True, icon="HIDE_OFF" if preview.is_on() else "HIDE_ON")


def draw_engine_work(layout: bpy.types.UILayout, work: interpreter.Check) -> None:
    """Draw the progress of a check of the engine, with the button that stops it."""
    row = layout.row(align=True)
    row.progress(factor=work.value, text=translate(work.stage))
    row.operator("s2ag.engine_cancel", text="", icon="X")
