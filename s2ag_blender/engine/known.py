"""What is known of the engine: which Python runs it, what the last look at it found, and how a full one is made outside."""

import functools
import os
import shlex
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...core import extras
from ...core.errors import S2agError, WorkerFailed
from ...core.setup import environment
from ...core.start import module_command
from ..translations import told
from .client import find_interpreter

PACKAGE = __package__.removesuffix(".s2ag_blender.engine")
"""The extension's name, under which Blender keeps its preferences."""
FOLDER = "s2ag-engine"
"""Where the set-up command makes an engine unless the preferences say otherwise, in the user's home."""


@dataclass
class State:
    """What the preferences show and cannot be read from them; never saved."""

    work: object = None
    """A :class:`trial.Check` that is under way."""
    chosen: str = ""
    """The engine that it tries and that is kept if it works; "" for the one that is kept already."""
    engine: str = ""
    """The choice where the extension is registered without being installed, and so has no preferences."""
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


def chosen(context) -> str:
    """The engine that the user chose: a folder or a Python; "" for the one that comes with the extension."""
    kept = settings(context)
    return bpy.path.abspath(kept.engine) if kept else STATE.engine


def keep(context, path: str) -> None:
    """Use the engine at ``path`` from now on; "" is the one that comes with the extension."""
    kept = settings(context)
    if kept:
        kept.engine = path
    STATE.engine = path
    look(context)


def engine(context=None) -> environment.Environment | None:
    """The environment that was chosen, if the set-up command made it, else None; cheap enough for drawing."""
    path = chosen(context or bpy.context)
    if not path:
        return None
    place = Path(path)
    place = place if place.is_dir() else place.parent.parent
    written = (place / "engine.json", *place.glob("engine-*/engine.json"))
    return _engine(place, tuple((str(one), one.stat().st_mtime_ns) for one in written if one.exists()))


@functools.lru_cache(maxsize=1)
def _engine(place: Path, _written: tuple) -> environment.Environment | None:
    return environment.environment(place)


def interpreter(context) -> str | None:
    """The engine's Python, as the user chose it; None lets the client find one."""
    path = chosen(context)
    if not path:
        return None
    try:
        return environment.chosen(path)
    except environment.SetupFailed:
        return path  # the client says that it cannot be run


def ships(context) -> bool:
    """Whether gestures are made by the engine that comes with the extension, in Blender's own Python."""
    return not chosen(context) and not os.environ.get("S2AG_PYTHON")


def facts(context=None) -> dict:
    """What is known of the engine: the inventory of the last check, or that of the environment when it was made."""
    if STATE.facts is not None:
        return STATE.facts
    made = engine(context)
    return made.facts if made else {}


def recogniser(context) -> bool | None:
    """Whether the engine can recognise speech; None where that is not known before it is asked to."""
    known = facts(context)
    if not known and ships(context):
        return extras.recogniser()  # it runs in this very Python
    return known.get("recogniser", False if engine(context) else None) if known else None


def look(context) -> None:
    """Forget what was found; what is known without running anything is shown until the next check."""
    STATE.facts, STATE.error = None, None


def cost(context) -> str:
    """What the set-up command fetches and takes, said before it is run."""
    kept = settings(context)
    fetched, taken = (f"{size / 1e9:g}" for size in environment.size(kept is None or kept.cpu_only))
    if kept is not None and kept.wheels:
        return told("Takes about {taken} GB of disk", taken=taken)
    return told("Fetches about {fetched} GB and takes {taken} GB of disk", fetched=fetched, taken=taken)


def set_up_folder(context) -> Path:
    """Where the set-up command makes an engine."""
    kept = settings(context)
    return Path(bpy.path.abspath(kept.folder)) if kept and kept.folder else Path.home() / FOLDER


def set_up_command(context, recognise: bool = False) -> str:
    """What a terminal takes to make a full engine, as the preferences want it; nothing in Blender runs it.

    In any case with the speech recogniser if ``recognise``. On Windows it is for PowerShell.
    """
    kept = settings(context)
    words = [*module_command(_python(), "core.cli.engine_alone"), "setup", str(set_up_folder(context))]
    if kept and kept.wheels:
        words += ["--wheels", bpy.path.abspath(kept.wheels)]
    elif kept and not kept.cpu_only:
        words.append("--cuda")
    if recognise or (kept and kept.recognise):
        words.append("--recognise")
    if os.name == "nt":
        return "& " + " ".join("'" + word.replace("'", "''") + "'" for word in words)
    return shlex.join(words)


def _python() -> str:
    """A Python that can run the set-up: Blender's own, where it is a program of its own."""
    try:
        return find_interpreter()
    except WorkerFailed:
        return "py" if os.name == "nt" else "python3"
