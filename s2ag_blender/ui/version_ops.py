"""Operators on the versions of a take: Follow Sound, which brings all of them along, and those that flip through them."""
# pyright: reportInvalidTypeForm=false

import bpy

from ..datablocks import ArmatureObject, Context
from ..takes import generate, retiming, session, take_list, versions
from ..takes.operator_base import GeneratingOperator
from ..translations import translate
from .bases import OperatorResult, require_character
from .take_ops import OnTake


class S2AG_OT_follow_sound(GeneratingOperator, OnTake, bpy.types.Operator):
    """Bring the selected take, with all its versions, to where its sound is now: moved, trimmed, stretched, or said anew"""

    bl_label = "Follow Sound"

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        armature = require_character(context)
        if session.run_of(armature) is not None:
            return translate("Gestures are being made")
        moved = retiming.change(take_list.active(armature).action, context.scene)
        return "" if moved else translate("The sound strip lies where it lay")

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        return generate.follow_arguments(context, armature)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        what = _sound_change(context)
        return super().invoke(context, event) if what.replaced or what.grown else self.execute(context)

    def execute(self, context: Context) -> OperatorResult:
        what = _sound_change(context)
        return super().execute(context) if what.replaced or what.grown else OnTake.execute(self, context)

    def work(self, context: Context) -> str:
        what = _sound_change(context)
        retiming.follow(require_character(context), context.scene)
        return retiming.change_sentence(what)


def _sound_change(context: Context) -> "retiming.Change":
    """Return how the sound of the selected take has changed, where a poll has made sure that it has."""
    what = retiming.change(take_list.active(require_character(context)).action, context.scene)
    assert what is not None
    return what


class _OnVersions(OnTake):
    """Base of operators on the versions of a take."""

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        several = versions.version_position(take_list.active(require_character(context)))[1] > 1
        return "" if several else translate("This take has one version only")


class S2AG_OT_flip_version(_OnVersions, bpy.types.Operator):
    """Show what the selected take was before an edit, or another alternative; nothing is made anew"""

    bl_label = "Flip Versions"

    back: bpy.props.BoolProperty(
        name="Back", description="Show the version before instead of the next one", options={"SKIP_SAVE"}
    )

    def work(self, context: Context) -> None:
        versions.flip(require_character(context), -1 if self.back else 1)


class S2AG_OT_drop_versions(_OnVersions, bpy.types.Operator):
    """Delete all versions of the selected take but the one that is shown"""

    bl_label = "Keep This Version"

    def work(self, context: Context) -> str:
        count = versions.drop_others(require_character(context))
        return translate("{count} versions deleted", count=count)
