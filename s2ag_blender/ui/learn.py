"""Operators that learn from hand-made animation: it is saved with its speech as training data, and becomes a style."""
# pyright: reportInvalidTypeForm=false

from collections.abc import Generator
from typing import Any, cast

import bpy

from ..datablocks import Context, current_context
from ..engine import engine_state
from ..takes import drafts, learning, menu_items, sources
from ..takes.operator_base import SlicedOperator
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
        if not bpy.app.background and context.window is not None:
            cast(Any, bpy.ops).s2ag.own_style("INVOKE_DEFAULT", filepath=str(path))  # scripts decide that for themselves
        return translate("{name} is saved; train with: s2ag data plain", name=path.name)


class S2AG_OT_own_style(SlicedOperator, NeedsCharacter, bpy.types.Operator):
    """Add a style of your own to the menu: one that was learned, or one to learn from a motion file of somebody who talks"""

    bl_label = "Style from File"

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"})
    filter_glob: bpy.props.StringProperty(default="*.json;*.npz;*.bvh", options={"HIDDEN"})

    def slices(self, context: Context) -> Generator[float, None, str]:
        settings = require_character(context).s2ag
        weights = menu_items.speakers_and_controls(settings).get("hash", "")
        return learning.style_in_slices(bpy.path.abspath(self.filepath), weights, engine_state.interpreter(context))

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        if self.filepath:
            return super().invoke(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> OperatorResult:
        if not bpy.app.background and context.window is not None:
            return cast(Any, bpy.ops).s2ag.own_style("INVOKE_DEFAULT", filepath=self.filepath)
        return super().execute(context)

    def finished(self, outcome: str) -> OperatorResult:
        require_character(current_context()).s2ag.style_pick = outcome
        self.report({"INFO"}, translate("The style {name} is in the menu", name=outcome))
        return {"FINISHED"}
