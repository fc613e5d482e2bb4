"""Where the engine runs, what is known of it, and how a full one is made and chosen."""

import os
import sys
import textwrap

import bpy

from .. import compat
from ..engine import errors_log, known
from ..translations import told, told_error
from . import menus

_WIDTH = 96


def _look_again(self, context):
    known.look(context)


class S2AG_Preferences(bpy.types.AddonPreferences):
    bl_idname = known.PACKAGE

    engine: bpy.props.StringProperty(
        name="Full Engine",
        description="Folder that the set-up command was given, or a Python with the engine's packages; leave empty for the "
        "engine that comes with the extension",
        subtype="FILE_PATH",
        options=compat.RELATIVE,
        update=_look_again,
    )
    folder: bpy.props.StringProperty(
        name="Make It In",
        description="Folder in which the set-up command makes the engine; leave empty for s2ag-engine in your home",
        subtype="DIR_PATH",
        options=compat.RELATIVE,
    )
    wheels: bpy.props.StringProperty(
        name="Packages",
        description="Folder with the .whl files of all packages that the engine needs; leave empty for the package registry",
        subtype="DIR_PATH",
        options=compat.RELATIVE,
    )
    cpu_only: bpy.props.BoolProperty(
        name="Small PyTorch",
        description="On Linux, fetch PyTorch's build without CUDA, from PyTorch's own index: a tenth of the size, and all that "
        "the engine uses",
        default=True,
    )
    recognise: bpy.props.BoolProperty(
        name="Also Recognise Speech",
        description="Install the speech recogniser, too, which writes down English recordings that have no transcript",
    )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        row = layout.split(factor=0.65)
        row.label(text="In the 3D viewport: press N, then choose the tab Gestures", icon="INFO")
        row.operator("s2ag.show_panel", icon="OUTLINER_OB_ARMATURE")
        _draw_found(layout.box().column(align=True))
        if known.STATE.work is not None:
            _draw_work(layout)
        if known.STATE.error is not None:
            _draw_error(layout)
        self._draw_full(layout, context)
        menus.draw_key(layout, context)

    def _draw_full(self, layout, context):
        header, body = layout.panel("s2ag_engine_options", default_closed=True)
        header.label(text="Advanced: Full Engine")
        if body is None:
            return
        about = told(
            "A Python environment of its own with PyTorch, for gesture models of other kinds, and with the speech recogniser "
            "if wanted. Gestures do not need it. It is made outside Blender: copy the command, run it in a terminal, then "
            "choose the engine."
        )
        _wrapped(body.column(align=True), about)
        body.prop(self, "folder")
        if sys.platform == "linux" and not self.wheels:
            body.prop(self, "cpu_only")
        body.prop(self, "recognise")
        body.prop(self, "wheels")
        body.label(text=known.cost(context), translate=False, icon="DISK_DRIVE")
        _wrapped(body.box().column(align=True), known.set_up_command(context))
        row = body.row()
        row.scale_y = 1.3
        row.operator("s2ag.copy_command", icon="COPYDOWN")
        row.operator("s2ag.engine_choose", icon="FILE_FOLDER")
        row = body.row()
        row.operator("s2ag.engine_check", icon="VIEWZOOM")
        row.operator("s2ag.engine_leave", icon="LOOP_BACK")
        body.prop(self, "engine")


def _draw_found(column) -> None:
    """What is known of the engine, a line each."""
    context = bpy.context
    facts = known.facts(context)
    if not facts:
        if known.ships(context):
            column.label(text="The engine that comes with the extension is used", icon="CHECKMARK")
        else:
            column.label(text="An engine is there that has not been tried yet", icon="QUESTION")
            _row(column, "Full Engine", known.chosen(context) or os.environ["S2AG_PYTHON"])
        return
    made = known.engine(context)
    if made and made.broken:
        column.label(text="The Python that the engine was made with is gone: run the set-up command again", icon="ERROR")
    elif made and made.outdated:
        column.label(text="This version needs other packages: run the set-up command again", icon="ERROR")
    else:
        column.label(text="The engine works", icon="CHECKMARK")
    _row(column, "Python", facts.get("interpreter", ""))
    _row(column, "Version", facts.get("python", ""))
    _row(column, "PyTorch", facts.get("packages", {}).get("torch", ""))
    _row(column, "S2AG", facts.get("s2ag", ""))
    _row(column, "Gesture Model", f"{facts.get('checkpoint', '')}  {facts.get('hash', '')[:12]}")
    _row(column, "Runs On", facts.get("device", ""))
    _row(column, "Recogniser", told("installed") if facts.get("recogniser") else told("not installed"))
    if made:
        _row(column, "Made", f"{made.facts.get('made', '')}, {made.facts.get('source', '')}")


def _row(column, name: str, value: str) -> None:
    row = column.split(factor=0.25)
    row.label(text=name)
    row.label(text=value, translate=False)


def _draw_work(layout) -> None:
    row = layout.row(align=True)
    row.progress(factor=known.STATE.work.value, text=told(known.STATE.work.stage, **known.STATE.work.names))
    row.operator("s2ag.engine_cancel", text="", icon="X")


def _draw_error(layout) -> None:
    box = layout.box().column(align=True)
    _wrapped(box, told_error(known.STATE.error), icon="ERROR")
    if errors_log.latest() is not None:
        box.operator("s2ag.open_log", icon="TEXT")


def _wrapped(column, text: str, icon: str = "NONE") -> None:
    for line in textwrap.wrap(text, _WIDTH, break_on_hyphens=False) or [""]:
        column.label(text=line, icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon
