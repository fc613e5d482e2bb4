"""Operator that saves hand-made animation of a character, with its speech, as training data."""
# pyright: reportInvalidTypeForm=false

import bpy

from ...core.errors import S2agError
from ..datablocks import Context
from ..takes import drafts, learning, sources
from ..takes.operator_base import character
from ..translations import translate, translate_error
from .bases import OperatorMixin, OperatorResult, may_run, require_character


class S2AG_OT_learn(OperatorMixin, bpy.types.Operator):
    """Save what this character does, with its speech, into a folder from which a network can be trained"""

    bl_idname = "s2ag.learn"
    bl_label = "Learn from This Action"

    directory: bpy.props.StringProperty(name="Folder", description="Folder of takes", subtype="DIR_PATH")

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        reason = ""
        if armature is None:
            reason = translate("Select a character's armature")
        elif armature.mode == "EDIT":
            reason = translate("Leave edit mode first")
        elif not learning.is_animated(armature):
            reason = translate("The character has no animation to learn from")
        else:
            reason = sources.missing_inputs(armature.s2ag, context.scene)
        return may_run(cls, reason)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> OperatorResult:
        armature = require_character(context)
        drafts.drop(armature)  # a draft is no animation of the user's
        try:
            path = learning.save_take(armature, bpy.path.abspath(self.directory), **learning.speech_of(armature, context.scene))
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        self.report({"INFO"}, translate("{name} is saved; train with: s2ag data plain", name=path.name))
        return {"FINISHED"}
