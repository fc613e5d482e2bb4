"""Panels below the main one: takes, expression, face, frames and sound, layers, body, bones, export, advanced."""

import bpy

from ..cast import facial
from ..keys import density, trying
from ..rig import facemaps, handpicked, readiness
from ..takes import choices, markers, takes
from ..takes.running import character
from ..translations import told
from .panel import Sidebar, draw_beyond, draw_progress, sentence
from .setting_properties import draw_group

_NAMES = 0.48
"""Share of a row that names of parts need."""
_BESIDE = 18
"""Letters for which there is room beside the name of a part."""


class _Below(Sidebar):
    """A closed panel below the main one, there while there is a character."""

    bl_parent_id = "S2AG_PT_gestures"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2  # below takes and what is done with their gestures

    @classmethod
    def poll(cls, context):
        return character(context) is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        armature = character(context)
        self.draw_settings(layout, armature, armature.s2ag, context)


class S2AG_UL_takes(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row(align=True)
        if item.action is None:
            row.label(text=item.title, icon="ERROR", translate=False)
            row.label(text="Its action is gone")
            return
        row.prop(item, "title", text="", emboss=False, icon="ACTION")
        row.prop(item, "keep", text="", emboss=False, icon="FAKE_USER_ON" if item.keep else "FAKE_USER_OFF")


class S2AG_PT_takes(_Below, bpy.types.Panel):
    bl_label = "Takes"
    bl_options = set()  # open at first: here is what the button makes
    bl_order = 0

    def draw_settings(self, layout, armature, settings, context):
        draw_group(layout.column(align=True), settings, "takes")
        row = layout.row()
        row.template_list("S2AG_UL_takes", "", settings, "takes", settings, "active_take", rows=4)
        column = row.column(align=True)
        column.operator("s2ag.delete_take", text="", icon="REMOVE")
        column.operator("s2ag.delete_others", text="", icon="TRASH")
        take = takes.active(armature)
        if take is None:
            layout.label(text="Takes to choose from appear here", icon="INFO")
        elif take.recording:
            layout.label(text=told("{name} from frame {frame}", name=take.recording, frame=take.first), icon="SOUND")
        column = layout.column(align=True)
        column.operator("s2ag.reroll", icon="FILE_REFRESH")
        column.operator("s2ag.vary", icon="MOD_NOISE")
        column.operator("s2ag.style_grid", icon="MESH_GRID")
        draw_progress(column, armature)
        layout.operator("s2ag.recall_take", icon="LOOP_BACK")


class S2AG_PT_expression(_Below, bpy.types.Panel):
    bl_label = "Expression"

    def draw_settings(self, layout, armature, settings, context):
        draw_blend(layout, settings)
        known = choices.control_names(settings.checkpoint)
        draw_group(layout, settings, "expression", steered=bool(known))
        layout.prop(settings, "partner")
        draw_group(layout, settings, "talk")
        if not known:
            layout.label(text="This gesture model has intensity only", icon="INFO")


def draw_blend(layout, settings) -> None:
    """What the style looks like, and a second one to blend in."""
    if choices.is_written(settings):
        return
    column = layout.column()
    about = choices.description(settings)
    for line in choices.wrapped(told(about)) if about else ():
        column.label(text=line, translate=False)
    if not choices.can_blend(settings):
        column.label(text="Random styles are not blended", icon="INFO")
        return
    column.prop(settings, "style_second_pick")
    if settings.style_second:
        column.prop(settings, "style_mix", slider=True)


class S2AG_PT_face(_Below, bpy.types.Panel):
    bl_label = "Face"

    def draw_settings(self, layout, armature, settings, context):
        draw_group(layout, settings, "face")
        row = layout.row(align=True)
        row.operator("s2ag.load_face_map", text="Load", icon="FILE_FOLDER")
        row.operator("s2ag.save_face_map", text="Save", icon="FILE_TICK")
        if facemaps.chosen(armature) is not None:
            row.operator("s2ag.reset_face_map", text="", icon="LOOP_BACK")
        found = facial.find(armature, look=bpy.app.background)
        if found is None:
            sentence(layout, told("No shape keys that speak were found"), "INFO")
            return
        layout.label(text=found.shapes.family, icon="CHECKMARK", translate=False)
        for part in found.missing:
            sentence(layout, told("Nothing for: {parts}", parts=told(part)), "INFO")


class S2AG_PT_frames(_Below, bpy.types.Panel):
    bl_label = "Frames and Sound"

    def draw_settings(self, layout, armature, settings, context):
        column = layout.column()
        column.prop(settings, "range")
        if settings.range == "OWN" and settings.audio_source != "STRIP":
            column.prop(settings, "start_frame")
        elif settings.range == "OWN":
            column.label(text="The strip tells the frames", icon="INFO")
        column = layout.column(heading="Add")
        sound = column.column()
        sound.active = settings.audio_source == "FILE" and settings.range != "STRIP"
        sound.prop(settings, "add_sound")
        if not sound.active:
            sentence(column, told("The sequencer plays the voice already"), "INFO")
        column.prop(settings, "add_markers")
        if settings.add_markers or markers.ours(context.scene, settings.marker_prefix):
            column.prop(settings, "marker_prefix")
            layout.operator("s2ag.remove_markers", icon="MARKER")


class S2AG_PT_layers(_Below, bpy.types.Panel):
    bl_label = "Layers and Blending"

    def draw_settings(self, layout, armature, settings, context):
        row = layout.row()
        row.use_property_split = False  # beside a label there is too little room for the three
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
            sentence(layout, told("A layer starts and ends in what is below it"), "INFO")


class S2AG_PT_body(_Below, bpy.types.Panel):
    bl_label = "Body"

    def draw_settings(self, layout, armature, settings, context):
        layout.column().prop(settings, "parts")
        column = layout.column(align=True)
        for part, name in (("TORSO", "torso_strength"), ("HEAD", "head_strength"), ("CLAVICLES", "clavicle_strength")):
            row = column.row()
            row.active = part in settings.parts
            row.prop(settings, name, slider=True)
        column.prop(settings, "palms", slider=True)
        if not {"TORSO", "HEAD", "CLAVICLES"} <= set(settings.parts):
            layout.label(text="Greyed parts are not keyed", icon="INFO")


class S2AG_PT_curves(_Below, bpy.types.Panel):
    bl_label = "Curves"

    def draw_settings(self, layout, armature, settings, context):
        layout.prop(settings, "speed", slider=True)
        layout.prop(settings, "smoothing", slider=True)
        layout.row().prop(settings, "curves", expand=True)
        for name, curves in (("tolerance", "POSES"), ("key_step", "FRAMES")):
            row = layout.row()
            row.active = settings.curves == curves
            row.prop(settings, name)
        take = takes.active(armature)
        dense = take is not None and density.is_dense(take.action)
        layout.operator("s2ag.change_keys", text="Key Only Poses" if dense else "Key All Frames", icon="IPO_BEZIER")


class S2AG_PT_bone_map(_Below, bpy.types.Panel):
    bl_label = "Bone Map"

    def draw_settings(self, layout, armature, settings, context):
        ready = readiness.known(armature)
        if settings.bone_map:
            layout.label(text="By hand; commas between bones", icon="GREASEPENCIL")
        elif ready is not None and ready.family:
            sentence(layout, told("Found as: {family}", family=ready.family), "ARMATURE_DATA")
        column = layout.column(align=True)
        if settings.bone_map:
            for item in settings.bone_map:
                row = column.split(factor=_NAMES)
                row.alert = not all(bone in armature.data.bones for bone in handpicked.split(item.bones))
                row.label(text=told(readiness.label(item.name)), translate=False)
                row = row.row(align=True)
                row.prop(item, "bones", text="")
                row.operator("s2ag.bones_from_selection", text="", icon="EYEDROPPER").part = item.name
        elif ready is not None:
            for found in ready.rows:
                row = column.row()
                row.label(text=told(readiness.label(found.part)), icon="CHECKMARK" if found.found else "REMOVE")
                note = told(found.note)
                if found.bones or len(note) <= _BESIDE:
                    row.label(text=", ".join(found.bones) or note, translate=False)
                else:
                    sentence(column, note, "BLANK1")
        for warning in ready.warnings if ready is not None else ():
            sentence(layout, told(warning), "ERROR")
        if settings.bone_map:
            layout.operator("s2ag.reset_bone_map", icon="LOOP_BACK")
        else:
            layout.operator("s2ag.edit_bone_map", icon="GREASEPENCIL")
        row = layout.row(align=True)
        row.operator("s2ag.select_bones", icon="RESTRICT_SELECT_OFF")
        row.operator("s2ag.test_pose", icon="LOOP_BACK" if trying.is_shown(armature) else "ARMATURE_DATA")
        row = layout.row(align=True)
        row.operator("s2ag.load_bone_map", text="Load", icon="FILE_FOLDER")
        row.operator("s2ag.save_bone_map", text="Save", icon="FILE_TICK")


class S2AG_PT_export(_Below, bpy.types.Panel):
    bl_label = "Export"

    def draw_settings(self, layout, armature, settings, context):
        column = layout.column(align=True)
        for suffix in ("bvh", "fbx", "glb"):
            operator = column.operator("s2ag.export", text=suffix.upper(), icon="EXPORT", translate=False)
            operator.format = f".{suffix}"
        if not draw_beyond(layout, armature, context.scene):
            layout.label(text="Exports the frames of the scene", icon="INFO")


class S2AG_PT_advanced(_Below, bpy.types.Panel):
    bl_label = "Advanced"

    def draw_settings(self, layout, armature, settings, context):
        draw_group(layout, settings, "advanced")
        layout.operator("s2ag.learn", icon="ACTION")


CLASSES = (
    S2AG_UL_takes,
    S2AG_PT_takes,
    S2AG_PT_expression,
    S2AG_PT_face,
    S2AG_PT_frames,
    S2AG_PT_layers,
    S2AG_PT_body,
    S2AG_PT_curves,
    S2AG_PT_bone_map,
    S2AG_PT_export,
    S2AG_PT_advanced,
)
