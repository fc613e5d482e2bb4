"""Drag and drop of a recording onto a character: sets its recording and offers to generate gestures in a dialog."""
# pyright: reportInvalidTypeForm=false

from pathlib import Path
from typing import Any

import bpy
from bpy_extras import view3d_utils

from ...core.words.transcript_search import find_transcript
from ..datablocks import ArmatureObject, Context, is_armature
from ..takes import sources
from ..takes.operator_base import armature_of, character
from ..translations import translate
from .bases import NeedsCharacter, OperatorMixin, OperatorResult, require_character

EXTENSIONS = (".wav", ".flac", ".mp3", ".ogg")
_MAX_PIXELS = 60
"""How far from the nearest joint a recording may be dropped on an armature without a mesh."""


def character_under(context: Context, x: int, y: int) -> ArmatureObject | None:
    """Return the armature whose mesh or joints are at pixel ``x``, ``y`` of the 3D viewport's region, or None."""
    region, view = context.region, context.region_data
    if view is None:
        return None
    origin = view3d_utils.region_2d_to_origin_3d(region, view, (x, y))
    direction = view3d_utils.region_2d_to_vector_3d(region, view, (x, y))
    hit, *_, item, _ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    if hit and (armature := armature_of(item.original)):
        return armature
    near = [(_distance(region, view, item, (x, y)), item.name) for item in context.visible_objects if is_armature(item)]
    distance, name = min(near, default=(_MAX_PIXELS, ""))
    return armature_of(context.scene.objects[name]) if distance < _MAX_PIXELS else None


def find_target(context: Context, x: int | None = None, y: int | None = None) -> ArmatureObject | None:
    """Return the character under the mouse, else the active one, else the scene's only one, else None."""
    armature = character_under(context, x, y) if x is not None and y is not None else None
    armature = armature or character(context)
    if armature is None:
        armatures = [item for item in context.scene.objects if is_armature(item)]
        armature = armatures[0] if len(armatures) == 1 else None
    return armature


def _distance(region: Any, view: Any, armature: ArmatureObject, pixel: tuple[int, int]) -> float:
    """Return the distance in pixels from ``pixel`` to the nearest joint of an armature."""
    world = armature.matrix_world
    joints = (view3d_utils.location_3d_to_region_2d(region, view, world @ bone.head) for bone in armature.pose.bones)
    return min(((joint.x - pixel[0]) ** 2 + (joint.y - pixel[1]) ** 2) ** 0.5 for joint in joints if joint is not None)


class S2AG_OT_drop_recording(OperatorMixin, bpy.types.Operator):
    """Let the character gesture to this recording"""

    bl_label = "Gesture to This Recording"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"})
    character: bpy.props.StringProperty(name="Character", description="Armature that gestures", options={"SKIP_SAVE"})
    generate: bpy.props.BoolProperty(
        name="Generate Now", description="Make the gestures at once, with the settings of the character", default=True
    )

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        armature = find_target(context, event.mouse_region_x, event.mouse_region_y)
        if armature is not None:
            self.character = armature.name
        return context.window_manager.invoke_props_dialog(self, width=360)

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.label(text=Path(self.filepath).name, icon="SOUND", translate=False)
        layout.prop_search(self, "character", context.scene, "objects", icon="ARMATURE_DATA")
        armature = armature_of(context.scene.objects.get(self.character))
        if armature is not None:
            layout.prop(armature.s2ag, "style_pick")
            layout.prop(armature.s2ag, "intensity", slider=True)
        transcript = find_transcript(self.filepath)
        if transcript:
            text = translate("{name} beside it tells the words", name=transcript.name)
            layout.label(text=text, icon="CHECKMARK", translate=False)
        else:
            layout.label(text="No transcript beside it: the sound alone gestures", icon="INFO")
        layout.prop(self, "generate")

    def execute(self, context: Context) -> OperatorResult:
        item = context.scene.objects.get(self.character) if self.character else find_target(context)
        armature = armature_of(item)
        if armature is None:
            self.report({"ERROR"}, translate("There is no character to gesture; select one"))
            return {"CANCELLED"}
        sources.set_recording(armature, self.filepath)
        for selected in context.selected_objects:
            selected.select_set(selected == armature)
        armature.select_set(True)
        context.view_layer.objects.active = armature
        if not self.generate:
            return {"FINISHED"}
        # With a window the operator runs modally behind a progress bar; without one the call blocks.
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        operators: Any = bpy.ops
        return {"CANCELLED"} if operators.s2ag.generate(how) == {"CANCELLED"} else {"FINISHED"}


class S2AG_OT_choose_recording(NeedsCharacter, bpy.types.Operator):
    """Choose the recording in a file browser that shows sound files alone"""

    bl_label = "Choose Recording"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"})
    filter_sound: bpy.props.BoolProperty(default=True, options={"SKIP_SAVE", "HIDDEN"})
    filter_folder: bpy.props.BoolProperty(default=True, options={"SKIP_SAVE", "HIDDEN"})

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        self.filepath = bpy.path.abspath(require_character(context).s2ag.audio)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: Context) -> None:
        sources.set_recording(require_character(context), self.filepath)


class S2AG_FH_recording(bpy.types.FileHandler):
    bl_idname = "S2AG_FH_recording"
    bl_label = "Recording for a Gesturing Character"
    bl_import_operator = "s2ag.drop_recording"
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context: Context) -> bool:
        """Accept recordings only in a 3D viewport of a scene with an armature; elsewhere Blender handles them."""
        area = context.area
        return bool(area and area.type == "VIEW_3D" and any(item.type == "ARMATURE" for item in context.scene.objects))
