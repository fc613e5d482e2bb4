"""Operator that saves hand-made animation of a character, with its speech, as training data."""
# pyright: reportInvalidTypeForm=false

import bpy

from ..datablocks import Context
from ..takes import drafts, learning, sources
from ..translations import translate
from .bases import NeedsCharacter, OperatorResult, require_character


class S2AG_OT_learn(NeedsCharacter, bpy.types.Operator):
    """Save what this character does, with its speech, into a folder from which a network can be trained"""

    bl_label = "Learn from This Action"
    bl_options = {"REGISTER"}

    directory: bpy.props.StringProperty(name="Folder", description="Folder of takes", subtype="DIR_PATH")

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        armature = require_character(context)
        if armature.mode == "EDIT":
            return translate("Leave edit mode first")
        if not learning.is_animated(armature):
            return translate("The character has no animation to learn from")
        return sources.missing_inputs(armature.s2ag, context.scene)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: Context) -> str:
        armature = require_character(context)
        drafts.drop(armature)  # a draft is no animation of the user's
        path = learning.save_take(armature, bpy.path.abspath(self.directory), **learning.speech_of(armature, context.scene))
        return translate("{name} is saved; train with: s2ag data plain", name=path.name)
