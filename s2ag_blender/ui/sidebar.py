"""The way to our tab of the sidebar for who does not know it yet."""

import bpy

from ..translations import told
from .panel import Sidebar

_WAIT, _TRIES = 0.1, 20  # tabs are known to Blender once the sidebar was drawn


class S2AG_OT_show_panel(bpy.types.Operator):
    """Open the sidebar of the 3D viewport at the tab Gestures"""

    bl_idname = "s2ag.show_panel"
    bl_label = "Show Gestures Panel"

    def execute(self, context):
        found = [area for window in context.window_manager.windows for area in window.screen.areas if area.type == "VIEW_3D"]
        if not found:
            self.report({"ERROR"}, told("No 3D viewport is open: open one, press N in it, then choose the tab Gestures"))
            return {"CANCELLED"}
        here = context.area if context.area in found else max(found, key=lambda area: area.width * area.height)
        here.spaces.active.show_region_ui = True
        left = iter(range(_TRIES))
        if not turned_to(here) and not bpy.app.background:  # where nothing is drawn no tab ever comes
            bpy.app.timers.register(lambda: _WAIT if next(left, None) is not None and not turned_to(here) else None)
        return {"FINISHED"}


def turned_to(area: bpy.types.Area) -> bool:
    """Turn an area's sidebar to our tab; whether Blender knows the tab by now."""
    sidebar = next((region for region in area.regions if region.type == "UI"), None)
    area.tag_redraw()
    try:
        sidebar.active_panel_category = Sidebar.bl_category
    except (AttributeError, TypeError):  # no sidebar, or one that was not drawn yet and has no tabs
        return False
    return True


CLASSES = (S2AG_OT_show_panel,)
