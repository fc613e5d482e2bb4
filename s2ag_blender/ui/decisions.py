"""The panel Decisions: each edit of the shown version, to be switched off, changed and removed, one by one."""
# pyright: reportInvalidTypeForm=false

from typing import Any

import bpy

from ...core.errors import UsageError
from ...core.settings import AFFECTS
from ..datablocks import Context
from ..takes import decisions, gesture_edits, menu_items, take_list
from ..takes.operator_base import character
from ..translations import translate
from .bases import OperatorResult, require_character
from .directing import RESTS, Directing, Formed, kinds_or_same
from .panel import Sidebar
from .setting_properties import SETTINGS

_CHANGEABLE = {
    "move": ("to",), "change": ("kind", "hand", "size"), "add": ("kind", "hand", "size"), "reroll": ("seed",), "rest": ("how",),
    "feel": ("arousal", "valence", "dominance"),
}  # fmt: skip
"""What can be changed about an edit."""
_WORDS = 166
"""Pixels of a line of words beside the buttons of a decision."""


def _control(name: str) -> Any:
    """Return the property of a feeling, with the words of its slider."""
    one = SETTINGS[name]
    return bpy.props.FloatProperty(name=one.label, description=one.tip, min=-1.0, max=1.0, subtype="FACTOR")


class _OnDecision(Directing):
    """Base of operators on one decision of the shown version."""

    number: bpy.props.IntProperty(default=-1, options={"HIDDEN", "SKIP_SAVE"})

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        edits = gesture_edits.edits_of(action)
        if not 0 <= self.number < len(edits):
            raise UsageError("There is no such decision.", "Choose one in the list.")
        return self.changed(edits), []

    def changed(self, edits: list[dict]) -> list[dict]:
        """Return the edits after the change."""
        raise NotImplementedError


class S2AG_OT_switch_decision(_OnDecision, bpy.types.Operator):
    """Take this decision back for now, or have it again; all others stay"""

    bl_label = "Switch Decision"

    def changed(self, edits: list[dict]) -> list[dict]:
        return decisions.switched(edits, self.number)


class S2AG_OT_remove_decision(_OnDecision, bpy.types.Operator):
    """Remove this decision from the list; all others stay"""

    bl_label = "Remove Decision"

    def changed(self, edits: list[dict]) -> list[dict]:
        return decisions.without(edits, self.number)


class S2AG_OT_change_decision(_OnDecision, Formed, bpy.types.Operator):
    """Decide this otherwise; all other decisions stay"""

    bl_label = "Change Decision"

    to: bpy.props.FloatProperty(
        name="To", description="Seconds of the recording to move it to", min=0.0, subtype="TIME_ABSOLUTE", options={"SKIP_SAVE"}
    )
    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=kinds_or_same)
    seed: bpy.props.IntProperty(name="Seed", description="Another seed is another performance", min=0)
    arousal: _control("arousal")
    valence: _control("valence")
    dominance: _control("dominance")
    how: bpy.props.EnumProperty(name="How", description="How much the passage rests", items=RESTS)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        edits = gesture_edits.edits_of(take_list.active(require_character(context)).action)
        if 0 <= self.number < len(edits):
            self.load(edits[self.number])
        return context.window_manager.invoke_props_dialog(self)

    def load(self, edit: dict[str, Any]) -> None:
        """Show what the edit asks for now."""
        usual = {"kind": "keep", "hand": "keep", "size": 1.0, "seed": 0, "how": "none", "to": 0.0}
        usual |= dict.fromkeys(AFFECTS, 0.0)
        for name in _CHANGEABLE.get(edit["do"], ()):
            setattr(self, name, edit.get(name, usual[name]))

    def draw(self, context: Context) -> None:
        edits = gesture_edits.edits_of(take_list.active(require_character(context)).action)
        for name in _CHANGEABLE.get(edits[self.number]["do"], ()) if 0 <= self.number < len(edits) else ():
            self.layout.prop(self, name)

    def changed(self, edits: list[dict]) -> list[dict]:
        edit = dict(edits[self.number])
        for name in _CHANGEABLE.get(edit["do"], ()):
            value = round(getattr(self, name), 4) if isinstance(getattr(self, name), float) else getattr(self, name)
            edit[name] = value
            if value == "keep" or (name == "size" and value == 1) or (name == "how" and value == "none"):
                del edit[name]
        if edit["do"] == "change" and not edit.keys() & {"kind", "hand", "size"}:
            raise UsageError("Nothing is to be changed.", "Choose another kind, hand or size.")
        return [*edits[: self.number], edit, *edits[self.number + 1 :]]


class S2AG_PT_decisions(Sidebar, bpy.types.Panel):
    bl_label = "Decisions"
    bl_parent_id = "S2AG_PT_directing"

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        take = take_list.active(armature) if armature is not None else None
        return take is not None and bool(gesture_edits.edits_of(take.action))

    def draw(self, context: Context) -> None:
        action = take_list.active(require_character(context)).action
        edits, unmet = gesture_edits.edits_of(action), decisions.unmet(action)
        column = self.layout.column(align=True)
        for number, edit in enumerate(edits):
            row = column.row(align=True)
            is_off = bool(edit.get("off"))
            button: Any = row.operator(
                "s2ag.switch_decision", text="", icon="CHECKBOX_DEHLT" if is_off else "CHECKBOX_HLT", emboss=False
            )
            button.number = number
            part = row.column(align=True)
            part.active, part.alert = not is_off, number in unmet
            words = decisions.words_of(edit, action, menu_items.gesture_label)
            words = translate("{words} (not possible here)", words=words) if number in unmet else words
            for line in menu_items.wrap_text(f"{number + 1} {words}", _WORDS):
                part.label(text=line, translate=False)
            if edit["do"] in _CHANGEABLE:
                button = row.operator("s2ag.change_decision", text="", icon="GREASEPENCIL", emboss=False)
                button.number = number
            button = row.operator("s2ag.remove_decision", text="", icon="X", emboss=False)
            button.number = number
