"""Operators for checking a bone map: select its bones, show a test pose, fill a row from the selection."""
# pyright: reportInvalidTypeForm=false

import bpy

from .. import compat
from ..datablocks import ArmatureObject, Context
from ..keys import test_pose
from ..rig import chosen_bones, readiness
from ..takes import bone_map_files, stored_settings
from ..translations import translate
from .bases import OfCharacter, require_character


def assign_bones(armature: ArmatureObject, part: str, names: list[str]) -> None:
    """Assign bones to a body part, lowest first, and remove them from all other parts."""
    for item in armature.s2ag.bone_map:
        kept = [name for name in chosen_bones.split(item.bones) if name not in names]
        item.bones = chosen_bones.join(names if item.name == part else kept)
    readiness.clear_cache(armature)


class S2AG_OT_bones_from_selection(OfCharacter, bpy.types.Operator):
    """Take the bones that are selected in pose mode, from the body outwards"""

    bl_label = "From the Selected Bones"

    part: bpy.props.EnumProperty(
        name="Part", description="Part of the body that the bones are", items=lambda operator, context: bone_map_files.parts()
    )

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        armature = require_character(context)
        if not armature.s2ag.bone_map:
            return translate("Press Choose Bones first")
        chosen = armature.mode == "POSE" and compat.selected_bones(armature)
        return "" if chosen else translate("Select the bones in pose mode first")

    def work(self, context: Context) -> None:
        armature = require_character(context)
        names = compat.selected_bones(armature)
        assign_bones(armature, self.part, names[:1] if self.part == "hips" else names)


class S2AG_OT_select_bones(OfCharacter, bpy.types.Operator):
    """Select the bones that gesture, in pose mode"""

    bl_label = "Show Bones"

    def work(self, context: Context) -> None:
        armature = require_character(context)
        context.view_layer.objects.active = armature
        if armature.mode != "POSE":
            bpy.ops.object.mode_set(mode="POSE")
        rows = readiness.readiness_of(armature).rows
        compat.select_bones(armature, [name for row in rows for name in row.bones if name in armature.data.bones])


class S2AG_OT_test_pose(OfCharacter, bpy.types.Operator):
    """Left hand up beside the head, right forearm forwards, head turned to its left; press again to go back"""

    bl_label = "Test Pose"

    def work(self, context: Context) -> None:
        armature = require_character(context)
        if test_pose.is_shown(armature):
            return test_pose.end_test_pose(armature)
        warnings: list[str] = []
        mapping = chosen_bones.mapping_of_settings(armature.s2ag)
        test_pose.show_test_pose(armature, context.scene, mapping, stored_settings.options(armature.s2ag), warnings.append)
        for warning in dict.fromkeys(warnings):
            self.report({"WARNING"}, translate(warning))
