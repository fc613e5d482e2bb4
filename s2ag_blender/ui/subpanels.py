"""Panels below the main one: takes, expression, face, frames and sound, layers, body, bones, export, advanced."""

from typing import Any

import bpy

from ..characters import face_lookup
from ..datablocks import ArmatureObject, Context
from ..keys import apply, density, test_pose
from ..rig import chosen_bones, facemaps, readiness
from ..takes import control_curves, markers, menu_items, take_list
from ..takes.operator_base import character
from ..translations import translate
from .bases import Icon, require_character
from .panel import Sidebar, draw_range_warning, draw_sentence
from .setting_properties import draw_group

_NAME_SHARE = 0.48
"""Share of a row for the names of parts."""
_MAX_NOTE_LETTERS = 18
"""Letters that fit beside the name of a part."""


class _SubPanel(Sidebar):
    """Base of panels below the main one, closed by default, shown while there is a character."""

    bl_parent_id = "S2AG_PT_gestures"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2  # below takes and their gestures

    @classmethod
    def poll(cls, context: Context) -> bool:
        return character(context) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        armature = require_character(context)
        self.draw_settings(layout, armature, armature.s2ag, context)

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        """Draw the content of the panel for a character."""
        raise NotImplementedError


class S2AG_UL_takes(bpy.types.UIList):
    def draw_item(
        self, context: Context, layout: bpy.types.UILayout, data: Any, item: Any, icon: Any, active_data: Any,
        active_property: Any, index: Any = 0, flt_flag: Any = 0,
    ) -> None:  # fmt: skip
        row = layout.row(align=True)
        if item.action is None:
            row.label(text=item.title, icon="ERROR", translate=False)
            row.label(text="Its action is gone")
            return
        row.prop(item, "title", text="", emboss=False, icon="ACTION")
        row.prop(item, "keep", text="", emboss=False, icon="FAKE_USER_ON" if item.keep else "FAKE_USER_OFF")


class S2AG_PT_takes(_SubPanel, bpy.types.Panel):
    bl_label = "Takes"
    bl_options = set()  # open by default, because the takes appear here
    bl_order = 0

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        draw_group(layout.column(align=True), settings, "takes")
        row = layout.row()
        row.template_list("S2AG_UL_takes", "", settings, "takes", settings, "active_take", rows=4)
        column = row.column(align=True)
        column.operator("s2ag.delete_take", text="", icon="TRASH")
        take = take_list.active(armature)
        if take is None:
            layout.label(text="Takes to choose from appear here", icon="INFO")
        else:
            text = translate("{name} from frame {frame}", name=take.recording or take.title, frame=take.first)
            layout.label(text=text, icon="SOUND" if take.recording else "USER")
        column = layout.column(align=True)
        column.operator("s2ag.reroll", icon="FILE_REFRESH")
        column.operator("s2ag.vary", icon="MOD_NOISE")
        column.operator("s2ag.style_grid", icon="MESH_GRID")
        column = layout.column(align=True)
        column.operator("s2ag.recall_take", icon="LOOP_BACK")
        column.operator("s2ag.idle", icon="USER")
        column.operator("s2ag.generate_strips", icon="SEQUENCE")
        row = column.row(align=True)
        row.operator("s2ag.insert_gesture", icon="VIEW_PAN")
        row.operator("s2ag.save_gesture", text="", icon="ASSET_MANAGER")
        column.operator("s2ag.delete_others", icon="TRASH")


class S2AG_PT_expression(_SubPanel, bpy.types.Panel):
    bl_label = "Expression"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        draw_blend(layout, settings)
        controls = menu_items.control_names(settings)
        draw_group(layout, settings, "expression", steered=bool(controls))
        take = take_list.active(armature)
        heard = control_curves.heard_now(take.action if take is not None else None, context.scene)
        if heard:
            text = translate("At the playhead: energy {arousal}, mood {valence}, confidence {dominance}", **heard)
            draw_sentence(layout, text, "SOUND")
            layout.operator("s2ag.key_heard", icon="FCURVE")
        layout.operator_menu_enum("s2ag.mark_style", "style", icon="MARKER")
        layout.prop(settings, "partner")
        draw_group(layout, settings, "talk")
        if not controls:
            layout.label(text="This gesture model has intensity only", icon="INFO")


def draw_blend(layout: bpy.types.UILayout, settings: Any) -> None:
    """Draw the choice of a second style to blend in."""
    if menu_items.is_written(settings):
        return
    column = layout.column()
    if not menu_items.can_blend(settings):
        column.label(text="Random styles are not blended", icon="INFO")
        return
    column.prop(settings, "style_second_pick")
    if settings.style_second:
        column.prop(settings, "style_mix", slider=True)


class S2AG_PT_face(_SubPanel, bpy.types.Panel):
    bl_label = "Face"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(require_character(context).s2ag, "face", text="")

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        draw_group(layout, settings, "face", switches=False)
        row = layout.row(align=True)
        row.operator("s2ag.load_face_map", text="Load", icon="FILE_FOLDER")
        row.operator("s2ag.save_face_map", text="Save", icon="FILE_TICK")
        if facemaps.read_face_map(armature) is not None:
            row.operator("s2ag.reset_face_map", text="", icon="LOOP_BACK")
        face = face_lookup.find(armature, look=False)
        if face is None:
            draw_sentence(layout, translate("No shape keys that speak were found"), "INFO")
            return
        layout.label(text=face.shapes.family, icon="CHECKMARK", translate=False)
        for part in face.missing:
            draw_sentence(layout, translate("Nothing for: {parts}", parts=translate(part)), "INFO")


class S2AG_PT_frames(_SubPanel, bpy.types.Panel):
    bl_label = "Frames and Sound"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        column = layout.column()
        column.prop(settings, "range")
        if settings.range == "OWN" and settings.audio_source != "STRIP":
            column.prop(settings, "start_frame")
        elif settings.range == "OWN":
            column.label(text="The strip tells the frames", icon="INFO")
        text = translate("Keyed at {fps:g} frames a second, as the scene", fps=apply.scene_fps(context.scene))
        draw_sentence(column, text, "INFO")
        column = layout.column(heading="Add")
        sound = column.column()
        sound.active = settings.audio_source == "FILE" and settings.range != "STRIP"
        sound.prop(settings, "add_sound")
        if not sound.active:
            draw_sentence(column, translate("The sequencer plays the voice already"), "INFO")
        column.prop(settings, "add_markers")
        if settings.add_markers or markers.ours(context.scene, settings.marker_prefix):
            column.prop(settings, "marker_prefix")
            layout.operator("s2ag.remove_markers", icon="MARKER")


class S2AG_PT_layers(_SubPanel, bpy.types.Panel):
    bl_label = "Layers and Blending"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        row = layout.row()
        row.use_property_split = False  # beside a label there is too little room for three buttons
        row.prop(settings, "result", expand=True)
        layered = settings.result == "LAYER"
        if settings.result != "ACTION":
            layout.prop(settings, "influence", slider=True)
        column = layout.column(align=True)
        column.prop(settings, "blend_in")
        column.prop(settings, "blend_out")
        ends = layout.column()
        ends.active = not layered
        ends.prop(settings, "start_pose")
        ends.prop(settings, "end_pose")
        if layered:
            draw_sentence(layout, translate("A layer starts and ends in what is below it"), "INFO")


class S2AG_PT_body(_SubPanel, bpy.types.Panel):
    bl_label = "Body"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        layout.column().prop(settings, "parts")
        column = layout.column(align=True)
        for part, name in (("TORSO", "torso_strength"), ("HEAD", "head_strength"), ("CLAVICLES", "clavicle_strength")):
            row = column.row()
            row.active = part in settings.parts
            row.prop(settings, name, slider=True)
        column.prop(settings, "palms", slider=True)
        column = layout.column(align=True)
        column.prop(settings, "seated")
        table = column.row()
        table.active = settings.seated != "OFF"
        table.prop(settings, "table")
        if not {"TORSO", "HEAD", "CLAVICLES"} <= set(settings.parts):
            layout.label(text="Grayed parts are not keyed", icon="INFO")


class S2AG_PT_curves(_SubPanel, bpy.types.Panel):
    bl_label = "Curves"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        layout.prop(settings, "speed", slider=True)
        layout.prop(settings, "smoothing", slider=True)
        layout.row().prop(settings, "curves", expand=True)
        for name, curves in (("tolerance", "POSES"), ("key_step", "FRAMES")):
            row = layout.row()
            row.active = settings.curves == curves
            row.prop(settings, name)
        take = take_list.active(armature)
        dense = take is not None and density.is_dense(take.action)
        layout.operator("s2ag.change_keys", text="Key Only Poses" if dense else "Key All Frames", icon="IPO_BEZIER")


class S2AG_PT_bone_map(_SubPanel, bpy.types.Panel):
    bl_label = "Bone Map"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        ready = readiness.cached(armature)
        if settings.bone_map:
            layout.label(text="By hand; commas between bones", icon="GREASEPENCIL")
        elif ready is not None and ready.family:
            draw_sentence(layout, translate("Found as: {family}", family=ready.family), "ARMATURE_DATA")
        column = layout.column(align=True)
        if settings.bone_map:
            for item in settings.bone_map:
                row = column.split(factor=_NAME_SHARE)
                row.alert = not all(bone in armature.data.bones for bone in chosen_bones.split(item.bones))
                row.label(text=translate(readiness.label(item.name)), translate=False)
                row = row.row(align=True)
                row.prop(item, "bones", text="")
                button: Any = row.operator("s2ag.bones_from_selection", text="", icon="EYEDROPPER")
                button.part = item.name
        elif ready is not None:
            for part in (*ready.rows, *ready.hands):
                row = column.row()
                icon: Icon = "CHECKMARK" if part.found else "REMOVE"
                row.label(text=translate(readiness.label(part.part)), icon=icon)
                note = translate(part.note)
                if part.bones or len(note) <= _MAX_NOTE_LETTERS:
                    few = part.bones if len(part.bones) < 4 else (f"{part.bones[0]} … {part.bones[-1]}",)
                    row.label(text=", ".join(few) or note, translate=False)
                else:
                    draw_sentence(column, note, "BLANK1")
        for warning in ready.warnings if ready is not None else ():
            draw_sentence(layout, translate(warning), "ERROR")
        if settings.bone_map:
            layout.operator("s2ag.reset_bone_map", icon="LOOP_BACK")
        else:
            layout.operator("s2ag.edit_bone_map", icon="GREASEPENCIL")
        row = layout.row(align=True)
        row.operator("s2ag.select_bones", icon="RESTRICT_SELECT_OFF")
        row.operator("s2ag.test_pose", icon="LOOP_BACK" if test_pose.is_shown(armature) else "ARMATURE_DATA")
        row = layout.row(align=True)
        row.operator("s2ag.load_bone_map", text="Load", icon="FILE_FOLDER")
        row.operator("s2ag.save_bone_map", text="Save", icon="FILE_TICK")


class S2AG_PT_export(_SubPanel, bpy.types.Panel):
    bl_label = "Export"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        column = layout.column(align=True)
        for suffix in ("bvh", "fbx", "glb"):
            button: Any = column.operator("s2ag.export", text=suffix.upper(), icon="EXPORT", translate=False)
            button.format = f".{suffix}"
        button = column.operator("s2ag.export", text="Film", icon="RENDER_ANIMATION")
        button.format = ".mp4"
        if not draw_range_warning(layout, armature, context.scene):
            layout.label(text="Exports the frames of the scene", icon="INFO")


class S2AG_PT_advanced(_SubPanel, bpy.types.Panel):
    bl_label = "Advanced"

    def draw_settings(self, layout: bpy.types.UILayout, armature: ArmatureObject, settings: Any, context: Context) -> None:
        draw_group(layout, settings, "advanced")
        layout.operator("s2ag.capture_film", icon="CAMERA_DATA")
        layout.operator("s2ag.learn", icon="ACTION")
        layout.operator("s2ag.own_style", icon="COMMUNITY")
