"""The panel Directing: the gestures of a take as a list, its versions, and the operators that edit gestures."""

from collections.abc import Sequence
from typing import Any

import bpy

from ...core.editing.names import BEAT
from ..datablocks import Context
from ..takes import gesture_edits, menu_items, retiming, take_list, versions
from ..takes.operator_base import character
from ..translations import translate
from .bases import OperatorResult, require_character
from .panel import Sidebar, draw_sentence, draw_warnings
from .take_ops import OnTake

_MIN_PIXELS, _NEW_SHARE = 150, 0.3
"""Height from which a Dope Sheet shows markers, and share of a viewport's height that a new Dope Sheet takes."""
_WORD_SHARE = 0.55
"""Share of a list row for frame and word."""
_SIZE_STEP = 1.6
"""Factor by which a press scales a gesture; smaller factors are hardly visible."""


class S2AG_UL_gestures(bpy.types.UIList):
    def draw_item(
        self, context: Context, layout: bpy.types.UILayout, data: Any, item: Any, icon: Any, active_data: Any,
        active_property: Any, index: Any = 0, flt_flag: Any = 0,
    ) -> None:  # fmt: skip
        gesture = next((one for one in gesture_edits.shown_gestures(data, context.scene) if one.name == item.name), None)
        if gesture is None:
            return
        row = layout.split(factor=_WORD_SHARE, align=True)
        moved = item.frame != gesture.frame
        hands = {"left": translate("Left"), "right": translate("Right"), "both": translate("Both")}
        kind = hands.get(gesture.hand, gesture.hand) if gesture.kind == BEAT else menu_items.gesture_label(gesture.kind)
        row.label(text=f"{item.frame}  {gesture.word}", icon="MARKER_HLT" if moved else "NONE", translate=False)
        row.label(text=kind, translate=False)

    def filter_items(self, context: Context, data: Any, prop: str) -> tuple[Sequence[int], Sequence[int]]:
        """Show markers of gestures only, sorted by frame."""
        marks = list(getattr(data, prop))
        names = {gesture.name for gesture in gesture_edits.shown_gestures(data, context.scene)}
        flags = [self.bitflag_filter_item if mark.name in names else 0 for mark in marks]
        places = sorted(range(len(marks)), key=lambda number: marks[number].frame)
        order = [0] * len(marks)
        for place, number in enumerate(places):
            order[number] = place
        return flags, order


class S2AG_OT_show_markers(OnTake, bpy.types.Operator):
    """Show the markers of the gestures in an Action Editor: move or delete them there, then apply that in the panel"""

    bl_label = "Show Markers"
    bl_options = {"REGISTER"}

    def execute(self, context: Context) -> OperatorResult:
        area = _dope_sheet(context)
        if area is None:
            self.report({"ERROR"}, translate("There is no room for a Dope Sheet in this window: open one first"))
            return {"CANCELLED"}
        context.view_layer.objects.active = character(context)  # whose action the editor shows
        space: Any = area.spaces.active
        space.mode = "ACTION"
        space.show_pose_markers = True
        return {"FINISHED"}


def _dope_sheet(context: Context) -> bpy.types.Area | None:
    """Return a Dope Sheet high enough to show markers, else split one off the largest viewport; None without room."""
    areas = list(context.screen.areas) if context.screen else []
    sheets = [area for area in areas if area.type == "DOPESHEET_EDITOR" and area.height >= _MIN_PIXELS]
    if sheets:
        return max(sheets, key=lambda area: area.height)
    views = [area for area in areas if area.type == "VIEW_3D" and area.height >= 2 * _MIN_PIXELS]
    if not views:
        return None
    with context.temp_override(area=max(views, key=lambda area: area.height), region=None):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=_NEW_SHARE)
    sheet = next(area for area in context.screen.areas if area not in areas)
    sheet.type = "DOPESHEET_EDITOR"
    space: Any = sheet.spaces.active
    space.show_region_ui = False
    return sheet


class S2AG_PT_directing(Sidebar, bpy.types.Panel):
    bl_label = "Directing"
    bl_parent_id = "S2AG_PT_gestures"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        return armature is not None and take_list.active(armature) is not None

    def draw(self, context: Context) -> None:
        layout, armature = self.layout, require_character(context)
        take = take_list.active(armature)
        session = context.window_manager.s2ag
        if gesture_edits.shown_gestures(take.action, context.scene):
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
        row = column.row(align=True)
        for text, how in ((translate("Rest"), "none"), (translate("Fewer"), "fewer"), (translate("Calmer"), "calmer")):
            button: Any = row.operator_menu_enum("s2ag.rest_range", "what", text=text, translate=False)
            button.how = how
        column.operator_menu_enum("s2ag.style_from", "style", icon="COMMUNITY")
        column.operator_menu_enum("s2ag.feeling_from", "mood", icon="HEART")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.add_gesture", "kind", text="Add Gesture", icon="ADD")
        row.operator_menu_enum("s2ag.add_at_word", "kind", text="", icon="VIEWZOOM")
        row.operator_menu_enum("s2ag.delete_gesture", "what", text="", icon="REMOVE")
        row = layout.row(align=True)
        row.operator_menu_enum("s2ag.change_gesture", "kind", text="Kind")
        row.operator_menu_enum("s2ag.change_gesture", "hand", text="Hands")
        row = layout.row(align=True)
        for text, size in ((translate("Smaller"), 1 / _SIZE_STEP), (translate("Larger"), _SIZE_STEP)):
            button = row.operator("s2ag.change_gesture", text=f"{text} × {size:.1f}", translate=False)
            button.size = size
        column = layout.column(align=True)
        column.operator_menu_enum("s2ag.keep_pose", "what", icon="PINNED")
        settings = armature.s2ag
        column.prop(settings, "target", text="")
        row = column.column(align=True)
        row.enabled = settings.target is not None
        row.operator_menu_enum("s2ag.keep_place", "hand", text="Hand at Object", icon="VIEW_PAN")
        button = row.operator_menu_enum("s2ag.keep_place", "hand", text="Point", icon="TRACKER")
        button.pointing = True


def draw_markers(layout: bpy.types.UILayout, take: Any, context: Context) -> None:
    """Draw the button that applies moved markers, with their number; without any, a hint how to move them."""
    edits = gesture_edits.edits_from_markers(take.action, context.scene)
    count = sum(len(edit["at"]) if isinstance(edit["at"], list) else 1 for edit in edits)
    if count:
        text = translate("Apply Moved Markers ({count})", count=count)
        layout.operator("s2ag.apply_markers", text=text, icon="MARKER_HLT", translate=False)
    elif gesture_edits.shown_gestures(take.action, context.scene):
        column = layout.column(align=True)
        draw_sentence(column, translate("To move or delete gestures, move or delete their markers"), "INFO")
        column.operator("s2ag.show_markers", icon="ACTION")


def draw_versions(layout: bpy.types.UILayout, take: Any) -> None:
    """Draw which version of a take is shown, and the buttons that flip through versions; of one, too, lest rows move."""
    at, count = versions.version_position(take)
    row = layout.row(align=True)
    button: Any = row.operator("s2ag.flip_version", text="", icon="TRIA_LEFT")
    button.back = True
    row.label(text=translate("Version {at} of {count}", at=at, count=count))
    button = row.operator("s2ag.flip_version", text="", icon="TRIA_RIGHT")
    button.back = False
    row.operator("s2ag.drop_versions", text="", icon="TRASH")
    draw_sentence(layout, versions.version_title(take) or translate("As it was generated"), "BLANK1")
    if count > 1:
        draw_warnings(layout, take)
