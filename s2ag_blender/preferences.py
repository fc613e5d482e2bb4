"""Where the engine runs, what is known of it, and how it is set up."""

import functools
import os
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..core.errors import S2agError, WorkerFailed
from . import client, compat, engine_setup
from .translations import told, told_error

_PACKAGE = __package__.rpartition(".")[0]
_WIDTH = 96


@dataclass
class State:
    """What the preferences show and cannot be read from them; never saved."""

    work: object = None
    """An :class:`engine_run.Setup` or :class:`engine_run.Check` that is under way."""
    facts: dict | None = None
    """What the last look at the engine found; None before the first look."""
    error: S2agError | None = None


STATE = State()


def _look_again(self, context):
    look(context)


class S2AG_Preferences(bpy.types.AddonPreferences):
    bl_idname = _PACKAGE

    interpreter: bpy.props.StringProperty(
        name="Engine Python",
        description="Python interpreter in which the engine's packages are installed; leave empty to find one",
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
        layout.label(text="The engine runs beside Blender, in a Python environment of its own")
        _draw_found(layout.box().column(align=True))
        if STATE.work is not None:
            _draw_work(layout)
        else:
            self._draw_buttons(layout)
        if STATE.error is not None:
            _draw_error(layout)
        self._draw_options(layout, context)

    def _draw_buttons(self, layout):
        row = layout.row()
        row.scale_y = 1.3
        made = engine()
        row.operator("s2ag.engine_setup", text="Repair" if made else "Set Up Engine", icon="FILE_REFRESH" if made else "IMPORT")
        row.operator("s2ag.engine_check", icon="VIEWZOOM")
        row.operator("s2ag.engine_remove", icon="TRASH")

    def _draw_options(self, layout, context):
        header, body = layout.panel("s2ag_engine_options", default_closed=engine() is not None)
        header.label(text="Set-up")
        if body is None:
            return
        body.row().prop(self, "source", expand=True)
        if self.source == "FOLDER":
            body.prop(self, "wheels")
        elif sys.platform == "linux":
            body.prop(self, "cpu_only")
        body.prop(self, "recognise")
        body.prop(self, "base_python")
        body.prop(self, "interpreter")
        try:
            text = planned(context, self, check=False).text
        except S2agError as error:
            _wrapped(body, told_error(error), icon="ERROR")
            return
        row = body.row()
        row.label(text="This is what is run:")
        row.operator("s2ag.copy_command", text="Copy", icon="COPYDOWN")
        lines = body.box().column(align=True)
        for command in text.splitlines():
            _wrapped(lines, command)


def settings(context=None) -> S2AG_Preferences | None:
    """The extension's preferences, or None where it is registered without being installed, as in tests and scripts."""
    addon = (context or bpy.context).preferences.addons.get(_PACKAGE)
    return addon.preferences if addon else None


@functools.cache
def folder() -> Path:
    """The folder where the extension may write: its own among Blender's extensions, else Blender's user data."""
    try:
        return Path(bpy.utils.extension_path_user(_PACKAGE))
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("DATAFILES")) / "s2ag"


def engine() -> engine_setup.Environment | None:
    """The environment that the set-up made, or None; cheap enough for drawing."""
    places = sorted(folder().glob("engine-*/engine.json")) if folder().is_dir() else []
    return _engine(tuple((str(place), place.stat().st_mtime_ns) for place in places))


@functools.lru_cache(maxsize=1)
def _engine(_written: tuple) -> engine_setup.Environment | None:
    return engine_setup.environment(folder())


def interpreter(context) -> str | None:
    """The engine's Python: the user's choice, else that of the environment made here; None lets the client find one."""
    chosen = settings(context)
    path = bpy.path.abspath(chosen.interpreter) if chosen else ""
    if path or os.environ.get("S2AG_PYTHON"):
        return path or None
    made = engine()
    return str(made.python) if made and not made.broken else None


def engine_known(context) -> bool:
    """Whether there is a Python that may run the engine; nothing is tried out, and drawing can ask at every redraw."""
    return _known(interpreter(context), os.environ.get("S2AG_PYTHON", ""))


@functools.lru_cache(maxsize=8)
def _known(python: str | None, _variable: str) -> bool:
    try:
        client.find_interpreter(python)
    except WorkerFailed:
        return False
    return True


def facts(context=None) -> dict:
    """What is known of the engine: the inventory of the last check, or that of the environment when it was made."""
    if STATE.facts is not None:
        return STATE.facts
    made = engine()
    return made.facts if made and str(made.python) == interpreter(context or bpy.context) else {}


def recogniser(context) -> bool | None:
    """Whether the engine can recognise speech; None where that is not known before it is asked to."""
    known = facts(context)
    return known.get("recogniser", False if is_own(known) else None) if known else None


def is_own(known: dict) -> bool:
    """Whether facts are about the environment that the set-up made."""
    made = engine()
    return made is not None and known.get("interpreter") == str(made.python)


def look(context) -> None:
    """Forget what was found; what is known without running anything is shown until the next check."""
    STATE.facts, STATE.error = None, None
    _known.cache_clear()


def planned(context, chosen=None, check: bool = True, recognise: bool = False) -> engine_setup.Plan:
    """The set-up as the preferences want it, in any case with the speech recogniser if ``recognise``.

    Raises :class:`engine_setup.SetupFailed` where it cannot be done.
    """
    chosen = chosen or settings(context)
    if chosen is None:
        return engine_setup.plan(folder(), check=check, recognise=recognise)
    wheels = bpy.path.abspath(chosen.wheels) if chosen.source == "FOLDER" else ""
    if check and chosen.source == "FOLDER" and not wheels:
        raise engine_setup.SetupFailed("No folder of wheels is chosen.", "Choose one in the preferences.")
    python = bpy.path.abspath(chosen.base_python)
    if check:
        return engine_setup.plan(folder(), python, wheels, chosen.cpu_only, recognise=recognise or chosen.recognise)
    return _quick(python, wheels, chosen.cpu_only, chosen.recognise, str(engine() and engine().folder))


@functools.lru_cache(maxsize=1)
def _quick(python: str, wheels: str, cpu_only: bool, recognise: bool, _made: str) -> engine_setup.Plan:
    return engine_setup.plan(folder(), python, wheels, cpu_only, check=False, recognise=recognise)


def _draw_found(column) -> None:
    """What is known of the engine, a line each."""
    context = bpy.context
    known, named = facts(context), interpreter(context)
    if not known:
        if engine_known(context):
            column.label(text="An engine is there that has not been tried yet", icon="QUESTION")
            _row(column, "Engine Python", named or os.environ.get("S2AG_PYTHON") or sys.executable)
        else:
            column.label(text="There is no engine yet", icon="INFO")
        return
    made, own = engine(), is_own(known)
    if own and made.broken:
        column.label(text="The Python that the engine was made with is gone: repair it", icon="ERROR")
    elif own and made.outdated:
        column.label(text="This version needs other packages than those installed: repair it", icon="ERROR")
    else:
        column.label(text="The engine works", icon="CHECKMARK")
    _row(column, "Engine Python", known.get("interpreter", ""))
    _row(column, "Version", known.get("python", ""))
    _row(column, "PyTorch", known.get("packages", {}).get("torch", ""))
    _row(column, "S2AG", known.get("s2ag", ""))
    _row(column, "Checkpoint", f"{known.get('checkpoint', '')}  {known.get('hash', '')[:12]}")
    _row(column, "Device", known.get("device", ""))
    _row(column, "Recogniser", told("installed") if known.get("recogniser") else told("not installed"))
    if own:
        _row(column, "Made", f"{made.facts.get('made', '')}, {made.facts.get('source', '')}")


def _row(column, name: str, value: str) -> None:
    row = column.split(factor=0.25)
    row.label(text=name)
    row.label(text=value, translate=False)


def _draw_work(layout) -> None:
    row = layout.row(align=True)
    row.progress(factor=STATE.work.value, text=told(STATE.work.stage, **STATE.work.names))
    row.operator("s2ag.engine_cancel", text="", icon="X")
    layout.label(text=STATE.work.line[:_WIDTH], translate=False)


def _draw_error(layout) -> None:
    box = layout.box().column(align=True)
    _wrapped(box, told_error(STATE.error), icon="ERROR")
    if getattr(STATE.error, "log", None):
        box.operator("s2ag.open_log", icon="TEXT")


def _wrapped(column, text: str, icon: str = "NONE") -> None:
    for line in textwrap.wrap(text, _WIDTH, break_on_hyphens=False) or [""]:
        column.label(text=line, icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon
