"""Operator that opens the sidebar at the tab Gestures; helps new users find it."""

from typing import Any

import bpy

from ..datablocks import Context
from ..translations import translate
from .bases import OperatorMixin, OperatorResult
from .panel import Sidebar

_WAIT, _MAX_TRIES = 0.1, 20
"""Seconds between tries to show the tab, and how many; tabs exist only once the sidebar was drawn."""


class S2AG_OT_show_panel(OperatorMixin, bpy.types.Operator):
    """Open the sidebar of the 3D viewport at the tab Gestures"""

    bl_label = "Show Gestures Panel"

    def execute(self, context: Context) -> OperatorResult:
        views = [area for window in context.window_manager.windows for area in window.screen.areas if area.type == "VIEW_3D"]
        if not views:
            self.report({"ERROR"}, translate("No 3D viewport is open: open one, press N in it, then choose the tab Gestures"))
            return {"CANCELLED"}
        view: Any = context.area if context.area in views else max(views, key=lambda area: area.width * area.height)
        view.spaces.active.show_region_ui = True
        tries = iter(range(_MAX_TRIES))
        if not show_tab(view) and not bpy.app.background:  # in background mode nothing is ever drawn
            bpy.app.timers.register(lambda: _WAIT if next(tries, None) is not None and not show_tab(view) else None)
        return {"FINISHED"}


def show_tab(area: bpy.types.Area) -> bool:
    """Show our tab in an area's sidebar; return False where the tab does not exist yet."""
    sidebar: Any = next((region for region in area.regions if region.type == "UI"), None)
    area.tag_redraw()
    try:
        sidebar.active_panel_category = Sidebar.bl_category
    except (AttributeError, TypeError):  # there is no sidebar, or it was not drawn yet and has no tabs
        return False
    return True
