"""The extension's preferences: which engine is used, what its last check found, and how to choose a full engine."""
# pyright: reportInvalidTypeForm=false

import os
import textwrap
from typing import Any

import bpy

from ...core.errors import S2agError
from ...core.version import VERSION
from .. import compat
from ..datablocks import Context, current_context
from ..engine import engine_state, errors_log
from ..translations import translate, translate_error
from .bases import Icon, LayoutMixin
from .panel import draw_engine_work

_LINE_LETTERS = 96


def _forget_check(preferences: Any, context: Any) -> None:
    engine_state.forget()


class S2AG_Preferences(LayoutMixin, bpy.types.AddonPreferences):
    bl_idname = engine_state.PACKAGE

    engine: bpy.props.StringProperty(
        name="Full Engine",
        description="Python with the package s2ag[full], or the folder of its environment; leave empty for the engine that "
        "comes with the extension",
        subtype="FILE_PATH",
        options=compat.RELATIVE,
        update=_forget_check,
    )

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        row = layout.split(factor=0.65)
        row.label(text="In the 3D viewport: press N, then choose the tab Gestures", icon="INFO")
        row.operator("s2ag.show_panel", icon="OUTLINER_OB_ARMATURE")
        row = layout.split(factor=0.65)
        row.label(text=f"S2AG {VERSION}, Blender {bpy.app.version_string}", icon="BLANK1", translate=False)
        buttons = row.row(align=True)
        buttons.operator("s2ag.open_help", icon="HELP")
        buttons.operator("s2ag.open_log", icon="TEXT")
        _draw_facts(layout.box().column(align=True))
        if engine_state.STATE.work is not None:
            draw_engine_work(layout, engine_state.STATE.work)
        if engine_state.STATE.error is not None:
            _draw_error(layout, engine_state.STATE.error)
        self._draw_full(layout, context)

    def _draw_full(self, layout: bpy.types.UILayout, context: Context) -> None:
        """Draw how to choose an engine of the user's own."""
        header, body = layout.panel("s2ag_engine_options", default_closed=True)
        header.label(text="Advanced: Full Engine")
        if body is None:
            return
        about = translate(
            "A Python of your own with PyTorch, for gesture models of other kinds and other devices, and with the speech "
            "recognizer if wanted. Gestures do not need it. It is 3.11 or newer, and made outside Blender: install the package "
            "there, then choose that Python."
        )
        _draw_wrapped(body.column(align=True), about)
        _draw_wrapped(body.box().column(align=True), 'python -m pip install "s2ag[full]"')
        row = body.row()
        row.scale_y = 1.3
        row.operator("s2ag.engine_choose", icon="FILE_FOLDER")
        row = body.row()
        row.operator("s2ag.engine_check", icon="VIEWZOOM")
        row.operator("s2ag.engine_leave", icon="LOOP_BACK")
        body.prop(self, "engine")


def _draw_facts(column: bpy.types.UILayout) -> None:
    """Draw the facts that the last check of the engine found, one per line."""
    context = current_context()
    facts = engine_state.facts()
    if not facts:
        if engine_state.is_bundled(context):
            column.label(text="The engine that comes with the extension is used", icon="CHECKMARK")
        else:
            column.label(text="An engine is there that has not been tried yet", icon="QUESTION")
            _row(column, "Full Engine", engine_state.chosen_path(context) or os.environ["S2AG_PYTHON"])
        return
    column.label(text="The engine works", icon="CHECKMARK")
    _row(column, "Python", facts.get("interpreter", ""))
    _row(column, "Version", facts.get("python", ""))
    _row(column, "PyTorch", facts.get("packages", {}).get("torch", ""))
    _row(column, "S2AG", facts.get("s2ag", ""))
    _row(column, "Gesture Model", f"{facts.get('checkpoint', '')}  {facts.get('hash', '')[:12]}")
    _row(column, "Runs On", facts.get("device", ""))
    _row(column, "Recognizer", translate("installed") if facts.get("recogniser") else translate("not installed"))


def _row(column: bpy.types.UILayout, name: str, value: str) -> None:
    row = column.split(factor=0.25)
    row.label(text=name)
    row.label(text=value, translate=False)


def _draw_error(layout: bpy.types.UILayout, error: S2agError) -> None:
    box = layout.box().column(align=True)
    _draw_wrapped(box, translate_error(error), icon="ERROR")
    if errors_log.latest() is not None:
        box.operator("s2ag.open_log", icon="TEXT")


def _draw_wrapped(column: bpy.types.UILayout, text: str, icon: Icon = "NONE") -> None:
    for line in textwrap.wrap(text, _LINE_LETTERS, break_on_hyphens=False) or [""]:
        column.label(text=line, icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon
