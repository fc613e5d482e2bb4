"""Where the engine runs, what is known of it, and how it is set up."""

import os
import sys
import textwrap

import bpy

from ...core.errors import S2agError
from .. import compat
from ..engine import known
from ..translations import told, told_error
from . import menus

_WIDTH = 96


def _look_again(self, context):
    known.look(context)


class S2AG_Preferences(bpy.types.AddonPreferences):
    bl_idname = known.PACKAGE

    interpreter: bpy.props.StringProperty(
        name="Engine Python",
        description="Python with the engine's packages; leave empty for the engine that comes with the extension",
        subtype="FILE_PATH",
        options=compat.RELATIVE,
        update=_look_again,
    )
    source: bpy.props.EnumProperty(
        name="Packages From",
        description="Where the engine's packages come from when it is set up",
        items=[
            ("REGISTRY", "Registry", "Download them from the Python package registry, which needs online access"),
            ("FOLDER", "Folder of Wheels", "Install them from a folder of .whl files, without any network"),
        ],
    )
    wheels: bpy.props.StringProperty(
        name="Wheels",
        description="Folder with the .whl files of all packages that the engine needs",
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
    base_python: bpy.props.StringProperty(
        name="Made With",
        description="Python 3.11 to 3.13 that makes the environment; leave empty for Blender's own or one on the search path",
        subtype="FILE_PATH",
        options=compat.RELATIVE,
    )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
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
            "A Python environment of its own with PyTorch, for checkpoints of other kinds, and with the speech recogniser if "
            "wanted. Gestures do not need it."
        )
        _wrapped(body.column(align=True), about)
        body.label(text=known.cost(context), translate=False, icon="DISK_DRIVE")
        if known.STATE.work is None:
            self._draw_buttons(body)
        self._draw_options(body, context)

    def _draw_buttons(self, layout):
        row = layout.row()
        row.scale_y = 1.3
        made = known.engine()
        row.operator("s2ag.engine_setup", text="Repair" if made else "Set Up Engine", icon="FILE_REFRESH" if made else "IMPORT")
        row.operator("s2ag.engine_check", icon="VIEWZOOM")
        row.operator("s2ag.engine_remove", icon="TRASH")

    def _draw_options(self, body, context):
        body.row().prop(self, "source", expand=True)
        if self.source == "FOLDER":
            body.prop(self, "wheels")
        elif sys.platform == "linux":
            body.prop(self, "cpu_only")
        body.prop(self, "recognise")
        body.prop(self, "base_python")
        body.prop(self, "interpreter")
        try:
            text = known.planned(context, self, check=False).text
        except S2agError as error:
            _wrapped(body, told_error(error), icon="ERROR")
            return
        row = body.row()
        row.label(text="This is what is run:")
        row.operator("s2ag.copy_command", text="Copy", icon="COPYDOWN")
        lines = body.box().column(align=True)
        for command in text.splitlines():
            _wrapped(lines, command)


def _draw_found(column) -> None:
    """What is known of the engine, a line each."""
    context = bpy.context
    facts, named = known.facts(context), known.interpreter(context)
    if not facts:
        if known.ships(context):
            column.label(text="The engine that comes with the extension is used", icon="CHECKMARK")
        else:
            column.label(text="An engine is there that has not been tried yet", icon="QUESTION")
            _row(column, "Engine Python", named or os.environ["S2AG_PYTHON"])
        return
    made, own = known.engine(), known.is_own(facts)
    if own and made.broken:
        column.label(text="The Python that the engine was made with is gone: repair it", icon="ERROR")
    elif own and made.outdated:
        column.label(text="This version needs other packages than those installed: repair it", icon="ERROR")
    else:
        column.label(text="The engine works", icon="CHECKMARK")
    _row(column, "Engine Python", facts.get("interpreter", ""))
    _row(column, "Version", facts.get("python", ""))
    _row(column, "PyTorch", facts.get("packages", {}).get("torch", ""))
    _row(column, "S2AG", facts.get("s2ag", ""))
    _row(column, "Checkpoint", f"{facts.get('checkpoint', '')}  {facts.get('hash', '')[:12]}")
    _row(column, "Device", facts.get("device", ""))
    _row(column, "Recogniser", told("installed") if facts.get("recogniser") else told("not installed"))
    if own:
        _row(column, "Made", f"{made.facts.get('made', '')}, {made.facts.get('source', '')}")


def _row(column, name: str, value: str) -> None:
    row = column.split(factor=0.25)
    row.label(text=name)
    row.label(text=value, translate=False)


def _draw_work(layout) -> None:
    row = layout.row(align=True)
    row.progress(factor=known.STATE.work.value, text=told(known.STATE.work.stage, **known.STATE.work.names))
    row.operator("s2ag.engine_cancel", text="", icon="X")
    layout.label(text=known.STATE.work.line[:_WIDTH], translate=False)


def _draw_error(layout) -> None:
    box = layout.box().column(align=True)
    _wrapped(box, told_error(known.STATE.error), icon="ERROR")
    if getattr(known.STATE.error, "log", None):
        box.operator("s2ag.open_log", icon="TEXT")


def _wrapped(column, text: str, icon: str = "NONE") -> None:
    for line in textwrap.wrap(text, _WIDTH, break_on_hyphens=False) or [""]:
        column.label(text=line, icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon
