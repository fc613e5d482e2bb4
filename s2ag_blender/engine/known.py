"""What is known of the engine: where it may be kept, which Python runs it, what the last look at it found."""

import functools
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...core import extras
from ...core.errors import S2agError
from ..translations import told
from . import setup

PACKAGE = __package__.removesuffix(".s2ag_blender.engine")
"""The extension's name, under which Blender keeps its preferences."""


@dataclass
class State:
    """What the preferences show and cannot be read from them; never saved."""

    work: object = None
    """An :class:`engine_run.Setup` or :class:`engine_run.Check` that is under way."""
    facts: dict | None = None
    """What the last look at the engine found; None before the first look."""
    error: S2agError | None = None


STATE = State()


def settings(context=None) -> bpy.types.AddonPreferences | None:
    """The extension's preferences, or None where it is registered without being installed, as in tests and scripts."""
    addon = (context or bpy.context).preferences.addons.get(PACKAGE)
    return addon.preferences if addon else None


@functools.cache
def folder() -> Path:
    """The folder where the extension may write: its own among Blender's extensions, else Blender's user data."""
    try:
        return Path(bpy.utils.extension_path_user(PACKAGE))
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("DATAFILES")) / "s2ag"


def engine() -> setup.Environment | None:
    """The environment that the set-up made, or None; cheap enough for drawing."""
    places = sorted(folder().glob("engine-*/engine.json")) if folder().is_dir() else []
    return _engine(tuple((str(place), place.stat().st_mtime_ns) for place in places))


@functools.lru_cache(maxsize=1)
def _engine(_written: tuple) -> setup.Environment | None:
    return setup.environment(folder())


def interpreter(context) -> str | None:
    """The engine's Python: the user's choice, else that of the environment made here; None lets the client find one."""
    chosen = settings(context)
    path = bpy.path.abspath(chosen.interpreter) if chosen else ""
    if path or os.environ.get("S2AG_PYTHON"):
        return path or None
    made = engine()
    return str(made.python) if made and not made.broken else None


def ships(context) -> bool:
    """Whether gestures are made by the engine that comes with the extension, in Blender's own Python."""
    return interpreter(context) is None and not os.environ.get("S2AG_PYTHON")


def facts(context=None) -> dict:
    """What is known of the engine: the inventory of the last check, or that of the environment when it was made."""
    if STATE.facts is not None:
        return STATE.facts
    made = engine()
    return made.facts if made and str(made.python) == interpreter(context or bpy.context) else {}


def recogniser(context) -> bool | None:
    """Whether the engine can recognise speech; None where that is not known before it is asked to."""
    known = facts(context)
    if not known and ships(context):
        return extras.recogniser()  # it runs in this very Python
    return known.get("recogniser", False if is_own(known) else None) if known else None


def is_own(known: dict) -> bool:
    """Whether facts are about the environment that the set-up made."""
    made = engine()
    return made is not None and known.get("interpreter") == str(made.python)


def look(context) -> None:
    """Forget what was found; what is known without running anything is shown until the next check."""
    STATE.facts, STATE.error = None, None


def cost(context) -> str:
    """What setting up the full engine fetches and takes, said before it is done."""
    chosen = settings(context)
    small = chosen is None or chosen.cpu_only
    fetched, taken = (f"{size / 1e9:g}" for size in setup.SIZES[small or sys.platform != "linux"])
    if chosen is not None and chosen.source == "FOLDER":
        return told("Takes about {taken} GB of disk", taken=taken)
    return told("Fetches about {fetched} GB and takes {taken} GB of disk", fetched=fetched, taken=taken)


def planned(context, chosen=None, check: bool = True, recognise: bool = False) -> setup.Plan:
    """The set-up as the preferences want it, in any case with the speech recogniser if ``recognise``.

    Raises :class:`engine_setup.SetupFailed` where it cannot be done.
    """
    chosen = chosen or settings(context)
    if chosen is None:
        return setup.plan(folder(), check=check, recognise=recognise)
    wheels = bpy.path.abspath(chosen.wheels) if chosen.source == "FOLDER" else ""
    if check and chosen.source == "FOLDER" and not wheels:
        raise setup.SetupFailed("No folder of wheels is chosen.", "Choose one in the preferences.")
    python = bpy.path.abspath(chosen.base_python)
    if check:
        return setup.plan(folder(), python, wheels, chosen.cpu_only, recognise=recognise or chosen.recognise)
    return _quick(python, wheels, chosen.cpu_only, chosen.recognise, str(engine() and engine().folder))


@functools.lru_cache(maxsize=1)
def _quick(python: str, wheels: str, cpu_only: bool, recognise: bool, _made: str) -> setup.Plan:
    return setup.plan(folder(), python, wheels, cpu_only, check=False, recognise=recognise)
