"""The panel of a take's gestures: which there are, which version is shown, and what can be done to them."""

import bpy

from ...core.direction import gestures
from ..takes import directing, retiming, takes, versions
from ..takes.running import character
from ..translations import told
from .directing import LABELS
from .panel import Sidebar, draw_progress, sentence
from .take_ops import OnTake

_HIGH, _PART = 150, 0.3
"""Pixels from which a Dope Sheet shows markers, and the share of a viewport that becomes one."""
_WORDS = 0.55
"""Share of a row of the list that frame and word have."""
_LARGER = 1.6
"""How much larger a press makes a gesture: less is hardly seen."""


class S2AG_UL_gestures(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        one = next((one for one in directing.shown(data, context.scene) if one.name == item.name), None)
        if one is None:
            return
        row = layout.split(factor=_WORDS, align=True)
        moved = item.frame != one.frame
        shown = _hand(one.hand) if one.kind == gestures.BEAT else told(LABELS.get(one.kind, one.kind))
        row.label(text=f"{item.frame}  {one.word}", icon="MARKER_HLT" if moved else "BLANK1", translate=False)
        row.label(text=shown, translate=False)

    def filter_items(self, context, data, prop):
        """Markers of gestures only, in order of time."""
        marks = list(getattr(data, prop))
        known = {one.name for one in directing.shown(data, context.scene)}
        flags = [self.bitflag_filter_item if mark.name in known else 0 for mark in marks]
        places = sorted(range(len(marks)), key=lambda number: marks[number].frame)
        order = [0] * len(marks)
        for place, number in enumerate(places):
            order[number] = place
        return flags, order


def _hand(name: str) -> str:
    """A hand in one word."""
    return {"left": told("Left"), "right": told("Right"), "both": told("Both")}.get(name, name)


class S2AG_OT_show_markers(OnTake, bpy.types.Operator):
    """Show the markers of the gestures in an Action Editor: move or delete them there, then apply that in the panel"""

    bl_idname = "s2ag.show_markers"
    bl_label = "Show Markers"
    bl_options = {"REGISTER"}

    def execute(self, context):
        area = _dope_sheet(context)
        if area is None:
            self.report({"ERROR"}, told("There is no room for a Dope Sheet in this window: open one first"))
            return {"CANCELLED"}
        context.view_layer.objects.active = character(context)  # whose action the editor shows
        area.spaces.active.mode = "ACTION"
        area.spaces.active.show_pose_markers = True
        return {"FINISHED"}


def _dope_sheet(context) -> bpy.types.Area | None:
    """A Dope Sheet of the window that is high enough to show markers, else the lower part of its viewport made one."""
    areas = list(context.screen.areas) if context.screen else []
    high = [area for area in areas if area.type == "DOPESHEET_EDITOR" and area.height >= _HIGH]
    if high:
        return max(high, key=lambda area: area.height)
    views = [area for area in areas if area.type == "VIEW_3D" and area.height >= 2 * _HIGH]
    if not views:
        return None
    with context.temp_override(area=max(views, key=lambda area: area.height), region=None):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=_PART)
    made = next(area for area in context.screen.areas if area not in areas)
    made.type = "DOPESHEET_EDITOR"
    return made


class S2AG_PT_directing(Sidebar, bpy.types.Panel):
    bl_label = "Directing"
    bl_parent_id = "S2AG_PT_gestures"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    @classmethod
    def poll(cls, context):
        armature = character(context)
        return armature is not None and takes.active(armature) is not None

    def draw(self, context):
        layout, take = self.layout, takes.active(character(context))
        draw_progress(layout, character(context))
        session = context.window_manager.s2ag
        if directing.shown(take.action, context.scene):
            layout.template_list("S2AG_UL_gestures", "", take.action, "pose_markers", session, "gesture", rows=5)
        else:
            layout.label(text="No gestures are known", icon="INFO")
        if retiming.change(take.action, context.scene):
            row = layout.row()
            row.alert = True
            row.operator("s2ag.follow_sound", icon="SOUND")
        draw_versions(layout, take)
        draw_markers(layout, take, context)
        column = layout.column(align=True)
        column.operator_menu_enum("s2ag.reroll_range", "what", icon="FILE_REFRESH")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.add_gesture", "kind", text="Add Gesture", icon="ADD")
        row.operator_menu_enum("s2ag.add_at_word", "kind", text="", icon="VIEWZOOM")
        row.operator("s2ag.delete_gesture", text="", icon="REMOVE")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.change_gesture", "kind", text="Kind")
        row.operator_menu_enum("s2ag.change_gesture", "hand", text="Hands")
        row = layout.row(align=True)
        for text, size in ((told("Smaller"), 1 / _LARGER), (told("Larger"), _LARGER)):
            row.operator("s2ag.change_gesture", text=f"{text} × {size:.1f}", translate=False).size = size
        column = layout.column(align=True)
        column.operator_menu_enum("s2ag.keep_pose", "what", icon="PINNED")
        settings = character(context).s2ag
        column.prop(settings, "target", text="")
        row = column.row(align=True)
        row.enabled = settings.target is not None
        row.operator_menu_enum("s2ag.keep_place", "hand", text="Hand at Object", icon="VIEW_PAN")


def draw_markers(layout, take, context) -> None:
    """How many gestures are to go elsewhere, and the button for it; else where one moves them."""
    count = len(directing.by_markers(take.action, context.scene))
    if count:
        text = told("Apply Moved Markers ({count})", count=count)
        layout.operator("s2ag.apply_markers", text=text, icon="MARKER_HLT", translate=False)
    elif directing.shown(take.action, context.scene):
        column = layout.column(align=True)
        sentence(column, told("To move or delete gestures, move or delete their markers"), "INFO")
        column.operator("s2ag.show_markers", icon="ACTION")


def draw_versions(layout, take) -> None:
    """Which version of a take is shown, and the buttons that flip through them."""
    at, count = versions.place(take)
    if count < 2:
        return
    row = layout.row(align=True)
    row.operator("s2ag.flip_version", text="", icon="TRIA_LEFT").back = True
    row.label(text=told("Version {at} of {count}", at=at, count=count))
    row.operator("s2ag.flip_version", text="", icon="TRIA_RIGHT").back = False
    row.operator("s2ag.drop_versions", text="", icon="TRASH")


CLASSES = (S2AG_UL_gestures, S2AG_OT_show_markers, S2AG_PT_directing)
