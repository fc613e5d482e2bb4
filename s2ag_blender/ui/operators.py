"""Operators of the panel, with one undo step each: thin wrappers of functions that scripts can call, too."""
# pyright: reportInvalidTypeForm=false

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy_extras.io_utils import ExportHelper

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context
from ..engine import engine_state
from ..rig import readiness
from ..takes import engine_requests, generate, markers, session, sources, take_list
from ..takes.operator_base import GeneratingOperator, character
from ..translations import translate, translate_error
from .bases import OperatorMixin, OperatorResult, may_run, require_character


def why_disabled(context: Context) -> str:
    """Return why gestures cannot be generated now, as a short phrase; empty if they can."""
    armature = character(context)
    if armature is None:
        return translate("Select a character's armature")
    if session.run_of(armature) is not None:
        return translate("Gestures are being made for this character")
    if armature.library is not None:
        return translate("The character is linked: make a library override of it first")
    if armature.mode == "EDIT":
        return translate("Leave edit mode first")
    ready = readiness.cached(armature)
    if ready is not None and ready.problem:
        return ready.problem
    if armature.s2ag.transcript_source == "RECOGNISE" and engine_state.has_recogniser(context) is False:
        return translate("The engine has no speech recognizer yet")
    return sources.missing_inputs(armature.s2ag, context.scene)


class S2AG_OT_generate(GeneratingOperator, bpy.types.Operator):
    """Make the character gesture to its recording"""

    bl_idname = "s2ag.generate"
    bl_label = "Generate Gestures"

    keep_decisions: bpy.props.BoolProperty(
        name="Keep Decisions",
        description="Do again what was decided about the selected take, where it still applies",
        default=True,
        options={"SKIP_SAVE"},
    )

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        return generate.plan_directed(context, armature) if self.keep_decisions else super().planned(context, armature)

    @classmethod
    def poll(cls, context: Context) -> bool:
        reason = why_disabled(context)
        return may_run(cls, reason)


class S2AG_OT_cancel(bpy.types.Operator):
    """Stop making gestures for this character; nothing has been changed"""

    bl_idname = "s2ag.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context: Context) -> bool:
        if session.run_of(character(context)) is not None:
            return True
        cls.poll_message_set(translate("No gestures are being made for this character"))
        return False

    def execute(self, context: Context) -> OperatorResult:
        run = session.run_of(character(context))
        if run is not None:
            run.cancel()
        return {"FINISHED"}


class NeedsCharacter(OperatorMixin):
    """Base of operators that need a character and nothing else."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if character(context) is not None:
            return True
        cls.poll_message_set(translate("Select a character's armature"))
        return False


class S2AG_OT_remove_markers(NeedsCharacter, bpy.types.Operator):
    """Remove the timeline markers that stand for words"""

    bl_idname = "s2ag.remove_markers"
    bl_label = "Remove Word Markers"

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        if armature is None or not markers.ours(context.scene, armature.s2ag.marker_prefix):
            cls.poll_message_set(translate("No marker starts with this prefix"))
            return False
        return True

    def execute(self, context: Context) -> OperatorResult:
        count = markers.remove(context.scene, require_character(context).s2ag.marker_prefix)
        self.report({"INFO"}, translate("{count} markers removed", count=count))
        return {"FINISHED"}


class S2AG_OT_export(NeedsCharacter, bpy.types.Operator, ExportHelper):
    """Write the character with its gestures as a file for other programs"""

    bl_idname = "s2ag.export"
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

    def execute(self, context: Context) -> OperatorResult:
        armature = require_character(context)
        try:
            engine_requests.export(context, armature, self.filepath)
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        if take_list.frames_beyond_scene(armature, context.scene) is not None:
            self.report({"WARNING"}, translate("Cut where the scene ends: {path}", path=self.filepath))
        else:
            self.report({"INFO"}, translate("Written: {path}", path=self.filepath))
        return {"FINISHED"}


class _AddCharacter(OperatorMixin):
    """Base of operators that build a character and make it the active object."""

    bl_options = {"REGISTER", "UNDO"}
    if TYPE_CHECKING:
        character: str

    def execute(self, context: Context) -> OperatorResult:
        try:
            armature = engine_requests.add_character(self.character, getattr(self, "gender", "female"))
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        for selected in context.selected_objects:
            selected.select_set(False)
        armature.select_set(True)
        context.view_layer.objects.active = armature
        return {"FINISHED"}


class S2AG_OT_add_human(_AddCharacter, bpy.types.Operator):
    """Add a person with a skeleton, ready to gesture"""

    bl_idname = "s2ag.add_human"
    bl_label = "Gesturing Human"
    character = "human"

    gender: bpy.props.EnumProperty(
        name="Gender", description="Whose body it has", items=[("female", "Woman", ""), ("male", "Man", "")]
    )


class S2AG_OT_add_mannequin(_AddCharacter, bpy.types.Operator):
    """Add a plain figure, ready to gesture"""

    bl_idname = "s2ag.add_mannequin"
    bl_label = "Gesturing Mannequin"
    character = "mannequin"
