"""Directing a take: the panel of its gestures, and the operators that change them."""

import bpy

from ...core.direction.edits import LARGEST, LEAST
from ...core.errors import UsageError
from .. import provenance
from ..takes import directing, generate, takes
from ..takes.running import Generating, character
from ..translations import told
from .operators import obstacle
from .panel import Sidebar

_AROUND = 4
"""Gestures before and after the playhead that the panel shows."""
_HANDS = (("left", "Left Hand", ""), ("right", "Right Hand", ""), ("both", "Both Hands", ""))
_AS_IT_IS = ("keep", "As It Is", "")
_KINDS = (
    ("beat", "Beat", "A stroke that the performer makes elsewhere in the take"),
    *(("shrug", "Shrug", ""), ("negation", "Negation", ""), ("refusal", "Refusal", ""), ("big", "Big", "")),
    *(("small", "Small", ""), ("one", "One", ""), ("two", "Two", ""), ("three", "Three", ""), ("me", "Me", "")),
    *(("you", "You", ""), ("here", "Here", ""), ("there", "There", ""), ("contrast", "Contrast", "")),
    *(("step", "Step", ""), ("question", "Question", "")),
)


class _Directing(Generating):
    """Base of operators that make a take once more after edits: it stands below the former one, which stays."""

    at_gesture = True

    @classmethod
    def poll(cls, context):
        armature = character(context)
        take = takes.active(armature) if armature is not None else None
        reason = obstacle(context) if armature is None or take is not None else told("Select a take in the list")
        if not reason and not (provenance.of(take.action) and directing.GESTURES in take.action):
            reason = told("The gestures of this take are not known: generate it again")
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def planned(self, context, armature):
        action = takes.active(armature).action
        before, more = self.edits(context, action)
        self._former = action.session_uid
        return generate.plan(context, armature, **directing.directed(action, [*before, *more]))

    def _done(self, uid, name, outcome):
        former = next((one for one in bpy.data.actions if one.session_uid == self._former), None)
        if former is not None:
            directing.settle(former, outcome.actions[0], bpy.context.scene)
        return super()._done(uid, name, outcome)

    def edits(self, context, action) -> tuple[list, list]:
        """The edits that stay, and those that come."""
        one = directing.nearest(action, context.scene) if self.at_gesture else None
        if self.at_gesture and one is None:
            raise UsageError("The take has no gesture.", "Add one.")
        return directing.made(action), [self.edit(context, action, one)]


def _asked(operator) -> dict:
    """Kind, hand and size as they were chosen."""
    chosen = {name: getattr(operator, name) for name in ("kind", "hand")}
    chosen = {name: value for name, value in chosen.items() if value != "keep"}
    return chosen | ({"size": round(operator.size, 3)} if abs(operator.size - 1) > 1e-3 else {})


class S2AG_OT_apply_markers(_Directing, bpy.types.Operator):
    """Move gestures to where their pose markers are now, and delete those whose markers are gone"""

    bl_idname = "s2ag.apply_markers"
    bl_label = "Apply Markers"

    def edits(self, context, action):
        more = directing.by_markers(action, context.scene)
        if not more:
            raise UsageError("All markers are where they were.", "Move or delete pose markers of the action first.")
        return directing.made(action), more


class S2AG_OT_delete_gesture(_Directing, bpy.types.Operator):
    """Make the phrase at the playhead anew without its gesture"""

    bl_idname = "s2ag.delete_gesture"
    bl_label = "Delete Gesture"

    def edit(self, context, action, one):
        return {"do": "delete", "at": one.at}


class S2AG_OT_change_gesture(_Directing, bpy.types.Operator):
    """Give the gesture at the playhead another kind, hand or size"""

    bl_idname = "s2ag.change_gesture"
    bl_label = "Change Gesture"

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=(_AS_IT_IS, *_KINDS))
    hand: bpy.props.EnumProperty(name="Hand", description="Which hand makes it", items=(_AS_IT_IS, *_HANDS))
    size: bpy.props.FloatProperty(
        name="Size", description="How large it is, in sizes that it has", default=1.0, min=LEAST, max=LARGEST
    )

    def edit(self, context, action, one):
        asked = _asked(self)
        if not asked:
            raise UsageError("Nothing is to be changed.", "Choose another kind, hand or size.")
        return {"do": "change", "at": one.at, **asked}


class S2AG_OT_add_gesture(_Directing, bpy.types.Operator):
    """Add a gesture whose stroke is at the playhead"""

    bl_idname = "s2ag.add_gesture"
    bl_label = "Add Gesture"
    at_gesture = False

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=_KINDS)
    hand: bpy.props.EnumProperty(name="Hand", description="Which hand makes it", items=(_AS_IT_IS, *_HANDS))
    size: bpy.props.FloatProperty(
        name="Size", description="How large it is, in sizes that it has", default=1.0, min=LEAST, max=LARGEST
    )

    def edit(self, context, action, one):
        return {"do": "add", "at": directing.seconds(action, context.scene, context.scene.frame_current), **_asked(self)}


class S2AG_OT_reroll_range(_Directing, bpy.types.Operator):
    """Make the preview range anew, each time with another seed; the takes are the alternatives"""

    bl_idname = "s2ag.reroll_range"
    bl_label = "Re-Roll Range"

    def edits(self, context, action):
        return directing.anew(action, context.scene)


class S2AG_PT_directing(Sidebar, bpy.types.Panel):
    bl_label = "Directing"
    bl_parent_id = "S2AG_PT_gestures"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        armature = character(context)
        return armature is not None and takes.active(armature) is not None

    def draw(self, context):
        layout, action = self.layout, takes.active(character(context)).action
        found = directing.shown(action, context.scene)
        here = directing.nearest(action, context.scene)
        place = found.index(here) if here else 0
        column = layout.box().column(align=True)
        if not found:
            column.label(text="No gestures are known", icon="INFO")
        for one in found[max(place - _AROUND, 0) : place + _AROUND + 1]:
            row = column.row()
            row.label(text=f"{one.frame}  {one.word}", icon="TRIA_RIGHT" if one == here else "DOT", translate=False)
            row.label(text=f"{one.kind}, {one.hand}", translate=False)
        column = layout.column(align=True)
        column.operator("s2ag.apply_markers", icon="MARKER_HLT")
        column.operator("s2ag.reroll_range", icon="FILE_REFRESH")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.add_gesture", "kind", text="Add Gesture", icon="ADD")
        row.operator("s2ag.delete_gesture", text="", icon="REMOVE")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.change_gesture", "kind", text="Kind")
        row.operator_menu_enum("s2ag.change_gesture", "hand", text="Hand")
        row.operator("s2ag.change_gesture", text="Smaller").size = 0.75
        row.operator("s2ag.change_gesture", text="Larger").size = 1.33


CLASSES = (
    S2AG_OT_apply_markers,
    S2AG_OT_delete_gesture,
    S2AG_OT_change_gesture,
    S2AG_OT_add_gesture,
    S2AG_OT_reroll_range,
)
PANELS = (S2AG_PT_directing,)
