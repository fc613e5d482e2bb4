"""Operators on takes: make more of them, keep or delete them, recall their settings, change their keys."""
# pyright: reportInvalidTypeForm=false

from typing import Any

import bpy

from .. import provenance
from ..datablocks import ArmatureObject, Context
from ..keys import apply, density
from ..takes import control_curves, drafts, generate, menu_items, take_list, versions
from ..takes.operator_base import GeneratingOperator, character
from ..translations import translate
from . import views
from .bases import Button, OperatorResult, require_character
from .operators import why_disabled


def selected(context: Context) -> tuple[ArmatureObject | None, Any]:
    """Return the character and its selected take, each None if there is none."""
    armature = character(context)
    return armature, take_list.active(armature) if armature is not None else None


class OnTake(Button):
    """Base of operators that need a selected take."""

    @classmethod
    def why_not(cls, context: Context) -> str:
        return "" if selected(context)[1] is not None else translate("Select a take in the list")


class OfTake(GeneratingOperator, Button):
    """Base of operators that generate new takes or versions from the selected take."""

    @classmethod
    def unknown(cls, take: Any) -> str:
        """Return which information, missing on a take, prevents the operator; empty if nothing is missing."""
        known = "settings" in (provenance.read(take.action) or {})
        return "" if known else translate("Nothing is known of how this take was made")

    @classmethod
    def why_not(cls, context: Context) -> str:
        armature, take = selected(context)
        reason = why_disabled(context) if armature is None or take is not None else translate("Select a take in the list")
        return reason or cls.unknown(take)


class S2AG_OT_change_keys(OnTake, bpy.types.Operator):
    """Key the selected take on every frame, or again on those that matter; edits by hand stay"""

    bl_label = "All Frames or Poses"

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        known = density.KEYED in selected(context)[1].action
        return "" if known else translate("Nothing is known of how this take was made")

    def work(self, context: Context) -> str:
        armature = require_character(context)
        take = take_list.active(armature)
        dense = density.is_dense(take.action)
        fps = apply.scene_fps(context.scene)
        density.convert(armature, take.action, armature.s2ag.tolerance if dense else None, fps)
        keys = density.most_keys(take.action)
        return translate("{name} has up to {count} keys a curve now", name=take.title, count=keys)


class S2AG_OT_key_heard(OnTake, bpy.types.Operator):
    """Key the sliders of energy, mood and confidence with what the selected take heard in the voice, to change it there"""

    bl_label = "Key What Is Heard"

    def work(self, context: Context) -> str:
        armature = require_character(context)
        drafts.drop(armature)
        count = control_curves.key_heard(armature, take_list.active(armature).action, context.scene)
        return translate("{count} keys; the next take is performed by them", count=count)


class S2AG_OT_reroll(OfTake, bpy.types.Operator):
    """Make another take with the settings of the selected one and a new seed"""

    bl_label = "Re-Roll"

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        action = take_list.active(armature).action
        return generate.plan(context, armature, **take_list.reroll_arguments(armature, action))


class S2AG_OT_vary(OfTake, bpy.types.Operator):
    """Make takes that are near the selected one"""

    bl_label = "Variations"

    spread: bpy.props.FloatProperty(
        name="Spread", description="How far variations go, as a share of how far takes differ",
        default=0.3, min=0.05, max=1.0, subtype="FACTOR",
    )  # fmt: skip
    count: bpy.props.IntProperty(name="Variations", description="How many variations to make", default=3, min=1, max=15)

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        action = take_list.active(armature).action
        return generate.plan(context, armature, **take_list.variation_arguments(armature, action, self.spread, self.count))


class S2AG_OT_style_grid(GeneratingOperator, Button, bpy.types.Operator):
    """Make one take in every style of the gesture model, to choose from"""

    bl_label = "One of Each Style"

    @classmethod
    def why_not(cls, context: Context) -> str:
        reason = why_disabled(context)
        if not reason and len(menu_items.style_names(require_character(context).s2ag)) < 2:
            reason = translate("This gesture model has one style only")
        return reason

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        styles = menu_items.style_names(armature.s2ag)
        return generate.plan(context, armature, styles=styles)


class S2AG_OT_keep_take(OnTake, bpy.types.Operator):
    """Keep the selected take when the others are deleted, or no longer keep it"""

    bl_label = "Keep Take"

    def work(self, context: Context) -> None:
        _, take = selected(context)
        take.keep = not take.keep


class S2AG_OT_delete_take(OnTake, bpy.types.Operator):
    """Delete the selected take with its action, and with all its versions"""

    bl_label = "Delete Take"

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        take = selected(context)[1]
        count = len(versions.version_actions(take))
        if count < 2:
            return self.execute(context)
        question = translate("Delete {name} with its {count} versions?", name=take.title, count=count)
        return context.window_manager.invoke_confirm(self, event, title=question)

    def work(self, context: Context) -> str:
        armature = require_character(context)
        name = take_list.active(armature).title
        take_list.delete(armature, [armature.s2ag.active_take])
        return translate("{name} is deleted", name=name)


class S2AG_OT_delete_others(OnTake, bpy.types.Operator):
    """Delete all takes that are not kept and not selected"""

    bl_label = "Delete Others"

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        doomed = take_list.others(require_character(context))
        if len(doomed) < 2:
            return self.execute(context)
        question = translate("Delete {count} takes that are neither kept nor selected?", count=len(doomed))
        return context.window_manager.invoke_confirm(self, event, title=question)

    def work(self, context: Context) -> str:
        count = take_list.delete_others(require_character(context))
        return translate("{count} takes deleted", count=count)


class S2AG_OT_recall_take(OnTake, bpy.types.Operator):
    """Set all settings to those that the selected take was made with"""

    bl_label = "Recall Settings"

    @classmethod
    def why_not(cls, context: Context) -> str:
        return super().why_not(context) or OfTake.unknown(selected(context)[1])

    def work(self, context: Context) -> str | None:
        armature = require_character(context)
        return take_list.recall_settings(armature, take_list.active(armature).action)


class S2AG_OT_fit_range(OnTake, bpy.types.Operator):
    """Lengthen the scene so that it shows all of the selected take"""

    bl_label = "Fit Range"

    def work(self, context: Context) -> None:
        take_list.fit_scene(require_character(context), context.scene)
        views.show_range(context)
