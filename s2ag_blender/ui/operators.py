"""Operators of the panel, with one undo step each: thin wrappers of functions that scripts can call, too."""
# pyright: reportInvalidTypeForm=false

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy_extras.io_utils import ExportHelper

from ..datablocks import ArmatureObject, Context
from ..engine import engine_state
from ..rig import readiness
from ..takes import engine_requests, generate, markers, session, sources, take_list
from ..takes.operator_base import GeneratingOperator, character
from ..translations import translate
from . import views
from .bases import Button, NeedsCharacter, OperatorResult, require_character, why_unchangeable


def why_disabled(context: Context) -> str:
    """Return why gestures cannot be generated now, as a short phrase; empty if they can."""
    armature = character(context)
    reason = why_unchangeable(armature)
    if armature is None or reason:
        return reason
    if session.run_of(armature) is not None:
        return translate("Gestures are being made for this character")
    ready = readiness.cached(armature)
    if ready is not None and ready.problem:
        return ready.problem
    if armature.s2ag.transcript_source == "RECOGNISE" and engine_state.has_recogniser(context) is False:
        return translate("The engine has no speech recognizer yet")
    return sources.missing_inputs(armature.s2ag, context.scene)


class S2AG_OT_generate(GeneratingOperator, Button, bpy.types.Operator):
    """Make the character gesture to its recording"""

    bl_label = "Generate Gestures"

    keep_decisions: bpy.props.BoolProperty(
        name="Keep Decisions",
        description="Do again what was decided about the selected take, where it still applies",
        default=True,
        options={"SKIP_SAVE"},
    )

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        return generate.plan_directed(context, armature) if self.keep_decisions else super().planned(context, armature)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        views.show_character(context, require_character(context))
        return super().invoke(context, event)

    @classmethod
    def why_not(cls, context: Context) -> str:
        return why_disabled(context)


class S2AG_OT_cancel(Button, bpy.types.Operator):
    """Stop making gestures for this character; nothing has been changed"""

    bl_label = "Cancel"
    bl_options = {"REGISTER"}

    @classmethod
    def why_not(cls, context: Context) -> str:
        running = session.run_of(character(context)) is not None
        return "" if running else translate("No gestures are being made for this character")

    def work(self, context: Context) -> None:
        run = session.run_of(character(context))
        if run is not None:
            run.cancel()


class S2AG_OT_remove_markers(NeedsCharacter, bpy.types.Operator):
    """Remove the timeline markers that stand for words"""

    bl_label = "Remove Word Markers"

    @classmethod
    def why_not(cls, context: Context) -> str:
        armature = character(context)
        found = armature is not None and markers.ours(context.scene, armature.s2ag.marker_prefix)
        return "" if found else translate("No marker starts with this prefix")

    def work(self, context: Context) -> str:
        count = markers.remove(context.scene, require_character(context).s2ag.marker_prefix)
        return translate("{count} markers removed", count=count)


class S2AG_OT_export(NeedsCharacter, bpy.types.Operator, ExportHelper):
    """Write the character with its gestures for other programs, or film what this viewport shows, with the sound"""

    bl_label = "Export Character"
    bl_options = {"REGISTER"}
    check_extension = True

    format: bpy.props.EnumProperty(
        name="Format",
        description="Kind of file",
        items=[
            (".bvh", "BVH", "The skeleton and its motion"),
            (".fbx", "FBX", "The character with its meshes and motion"),
            (".glb", "GLB", "The character with its meshes and motion, as glTF"),
            (".mp4", "Film", "What this viewport shows, with the sound"),
        ],
    )
    filter_glob: bpy.props.StringProperty(default="*.bvh;*.fbx;*.glb;*.mp4", options={"HIDDEN"})

    @property
    def filename_ext(self) -> str:
        return self.format

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        """Propose a path beside the .blend file, named after character and take."""
        name = engine_requests.file_name(require_character(context)) + self.format
        self.filepath = str(Path(bpy.data.filepath).with_name(name)) if bpy.data.filepath else name
        return super().invoke(context, event)

    def work(self, context: Context) -> str | None:
        armature = require_character(context)
        engine_requests.export(context, armature, self.filepath)
        if take_list.frames_beyond_scene(armature, context.scene) is None:
            return translate("Written: {path}", path=self.filepath)
        self.report({"WARNING"}, translate("Cut where the scene ends: {path}", path=self.filepath))


class _AddCharacter(Button):
    """Base of operators that build a character and make it the active object."""

    if TYPE_CHECKING:
        character: str

    def work(self, context: Context) -> None:
        armature = engine_requests.add_character(self.character, getattr(self, "gender", "female"))
        for selected in context.selected_objects:
            selected.select_set(False)
        armature.select_set(True)
        context.view_layer.objects.active = armature


class S2AG_OT_add_human(_AddCharacter, bpy.types.Operator):
    """Add a person with a skeleton, ready to gesture"""

    bl_label = "Gesturing Human"
    character = "human"

    gender: bpy.props.EnumProperty(
        name="Gender", description="Whose body it has", items=[("female", "Woman", ""), ("male", "Man", "")]
    )


class S2AG_OT_add_mannequin(_AddCharacter, bpy.types.Operator):
    """Add a plain figure, ready to gesture"""

    bl_label = "Gesturing Mannequin"
    character = "mannequin"
