"""Operators on bone maps and face maps: edited in the panel, loaded from and saved to files of ``s2ag rig``."""
# pyright: reportInvalidTypeForm=false

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.errors import RigUnusable
from ..characters import face_lookup
from ..datablocks import ArmatureObject, Context
from ..rig import facemaps
from ..takes import bone_map_files
from ..translations import translate
from .bases import OfCharacter, OperatorResult, require_character


class S2AG_OT_edit_bone_map(OfCharacter, bpy.types.Operator):
    """Choose the bones by hand, starting from those that were found"""

    bl_label = "Choose Bones"

    def work(self, context: Context) -> None:
        bone_map_files.edit(require_character(context))


class S2AG_OT_reset_bone_map(OfCharacter, bpy.types.Operator):
    """Go back to the bones that are found by themselves"""

    bl_label = "Find Bones"

    def work(self, context: Context) -> None:
        bone_map_files.reset(require_character(context))


class _WithJsonFile(OfCharacter):
    """Base of operators that load or save a ``.json`` file; those that save propose the character's name with a ``suffix``."""

    filename_ext = ".json"
    suffix = ""
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context: Context) -> str:
        path = bpy.path.abspath(self.filepath)
        return self.transfer(require_character(context), path)

    def transfer(self, armature: ArmatureObject, path: str) -> str:
        """Load or save the file, and return the news; may raise :class:`S2agError`."""
        raise NotImplementedError


class _Saving(_WithJsonFile, ExportHelper):
    bl_options = {"REGISTER"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        name = bpy.path.clean_name(require_character(context).name) + self.suffix + self.filename_ext
        self.filepath = self.filepath or name
        return ExportHelper.invoke(self, context, event)


class S2AG_OT_load_bone_map(_WithJsonFile, bpy.types.Operator, ImportHelper):
    """Take the bones of this character from a bone map, a file that Save writes"""

    bl_label = "Load Bone Map"

    def transfer(self, armature: ArmatureObject, path: str) -> str:
        bone_map_files.load(armature, path)
        return translate("{name} has the bones of {file}", name=armature.name, file=Path(path).name)


class S2AG_OT_save_bone_map(_Saving, bpy.types.Operator):
    """Write the bones of this character as a bone map, for characters of the same rig"""

    bl_label = "Save Bone Map"

    def transfer(self, armature: ArmatureObject, path: str) -> str:
        bone_map_files.save(armature, path)
        return translate("Written: {path}", path=path)


class S2AG_OT_load_face_map(_WithJsonFile, bpy.types.Operator, ImportHelper):
    """Take the shape keys and bones of this character's face from a face map, a file that Save writes"""

    bl_label = "Load Face Map"

    def transfer(self, armature: ArmatureObject, path: str) -> str:
        facemaps.store_face_map(armature, facemaps.shapes.load(path))
        return translate("{name} has the face of {file}", name=armature.name, file=Path(path).name)


class S2AG_OT_save_face_map(_Saving, bpy.types.Operator):
    """Write the shape keys and bones of this character's face as a face map, to edit or for characters alike"""

    bl_label = "Save Face Map"
    suffix = " face"

    def transfer(self, armature: ArmatureObject, path: str) -> str:
        face = face_lookup.face_map(armature)
        if face is None:
            raise RigUnusable(f"{armature.name} has no face that speaks.", "Give it shape keys or a jaw with a usual name.")
        facemaps.shapes.save(path, face)
        return translate("Written: {path}", path=path)


class S2AG_OT_reset_face_map(OfCharacter, bpy.types.Operator):
    """Go back to the face that is found by itself"""

    bl_label = "Find Face"

    def work(self, context: Context) -> None:
        facemaps.store_face_map(require_character(context), None)
