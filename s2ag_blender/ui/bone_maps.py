"""Operators on bone maps and face maps: edited in the panel, loaded from and saved to files of ``s2ag rig``."""
# pyright: reportInvalidTypeForm=false

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.errors import RigUnusable, S2agError
from ..characters import face_lookup
from ..datablocks import ArmatureObject, Context
from ..rig import facemaps
from ..takes import bone_map_files
from ..takes.operator_base import character
from ..translations import translate, translate_error
from .bases import OperatorMixin, OperatorResult, may_run, require_character


class OfCharacter(OperatorMixin):
    """Base of operators that change the active character; it must exist, be no linked data, and not be in edit mode."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        reason = ""
        if armature is None:
            reason = translate("Select a character's armature")
        elif armature.library is not None:
            reason = translate("The character is linked: make a library override of it first")
        elif armature.mode == "EDIT":
            reason = translate("Leave edit mode first")
        return may_run(cls, reason)


class S2AG_OT_edit_bone_map(OfCharacter, bpy.types.Operator):
    """Choose the bones by hand, starting from those that were found"""

    bl_idname = "s2ag.edit_bone_map"
    bl_label = "Choose Bones"

    def execute(self, context: Context) -> OperatorResult:
        bone_map_files.edit(require_character(context))
        return {"FINISHED"}


class S2AG_OT_reset_bone_map(OfCharacter, bpy.types.Operator):
    """Go back to the bones that are found by themselves"""

    bl_idname = "s2ag.reset_bone_map"
    bl_label = "Find Bones"

    def execute(self, context: Context) -> OperatorResult:
        bone_map_files.reset(require_character(context))
        return {"FINISHED"}


class _WithJsonFile(OperatorMixin):
    """Base of operators that load or save a ``.json`` file in ``work(armature, path)``, whose errors they report."""

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, armature: ArmatureObject, path: str) -> None:
        """Load or save the file; may raise :class:`S2agError`."""
        raise NotImplementedError

    def execute(self, context: Context) -> OperatorResult:
        try:
            self.work(require_character(context), bpy.path.abspath(self.filepath))
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class S2AG_OT_load_bone_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the bones of this character from a bone map, a file that Save writes"""

    bl_idname = "s2ag.load_bone_map"
    bl_label = "Load Bone Map"

    def work(self, armature: ArmatureObject, path: str) -> None:
        bone_map_files.load(armature, path)
        self.report({"INFO"}, translate("{name} has the bones of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_bone_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the bones of this character as a bone map, for characters of the same rig"""

    bl_idname = "s2ag.save_bone_map"
    bl_label = "Save Bone Map"
    bl_options = {"REGISTER"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        self.filepath = self.filepath or bpy.path.clean_name(require_character(context).name) + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature: ArmatureObject, path: str) -> None:
        bone_map_files.save(armature, path)
        self.report({"INFO"}, translate("Written: {path}", path=path))


class S2AG_OT_load_face_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the shape keys and bones of this character's face from a face map, a file that Save writes"""

    bl_idname = "s2ag.load_face_map"
    bl_label = "Load Face Map"

    def work(self, armature: ArmatureObject, path: str) -> None:
        facemaps.store_face_map(armature, facemaps.shapes.load(path))
        self.report({"INFO"}, translate("{name} has the face of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_face_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the shape keys and bones of this character's face as a face map, to edit or for characters alike"""

    bl_idname = "s2ag.save_face_map"
    bl_label = "Save Face Map"
    bl_options = {"REGISTER"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        self.filepath = self.filepath or bpy.path.clean_name(require_character(context).name) + " face" + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature: ArmatureObject, path: str) -> None:
        face = face_lookup.face_map(armature)
        if face is None:
            raise RigUnusable(f"{armature.name} has no face that speaks.", "Give it shape keys or a jaw with a usual name.")
        facemaps.shapes.save(path, face)
        self.report({"INFO"}, translate("Written: {path}", path=path))


class S2AG_OT_reset_face_map(OfCharacter, bpy.types.Operator):
    """Go back to the face that is found by itself"""

    bl_idname = "s2ag.reset_face_map"
    bl_label = "Find Face"

    def execute(self, context: Context) -> OperatorResult:
        facemaps.store_face_map(require_character(context), None)
        return {"FINISHED"}


CLASSES = (
    *(S2AG_OT_edit_bone_map, S2AG_OT_reset_bone_map, S2AG_OT_load_bone_map, S2AG_OT_save_bone_map),
    *(S2AG_OT_load_face_map, S2AG_OT_save_face_map, S2AG_OT_reset_face_map),
)
