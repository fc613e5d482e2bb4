"""State of the engine: which Python runs it, and what the last check of it found."""

import functools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy

from ...core import optional_packages
from ...core.errors import S2agError
from ...core.worker import interpreter as checks
from ..datablocks import Context, current_context

PACKAGE = cast(str, __package__).removesuffix(".s2ag_blender.engine")
"""The extension's package, the key of its preferences in Blender."""


@dataclass
class State:
    """State that the preferences show besides their own properties; never saved."""

    work: checks.Check | None = None
    """The running check."""
    chosen: str = ""
    """The engine that it checks and that is kept if it works; "" for the one in use."""
    engine: str = ""
    """The choice where the extension is registered without being installed, and so has no preferences."""
    facts: dict | None = None
    """What the last check of the engine found; None before the first."""
    error: S2agError | None = None


STATE = State()


def settings(context: Context | None = None) -> Any:
    """Return the extension's preferences, or None where it is registered without being installed, as in tests and scripts."""
    addon = (context or current_context()).preferences.addons.get(PACKAGE)
    return addon.preferences if addon else None


@functools.cache
def folder() -> Path:
    """Return the folder where the extension may write: its own among Blender's extensions, else Blender's user data."""
    try:
        return Path(bpy.utils.extension_path_user(PACKAGE))
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("DATAFILES")) / "s2ag"


def chosen_path(context: Context) -> str:
    """Return the engine that the user chose: a Python or a folder; "" for the one that comes with the extension."""
    preferences = settings(context)
    return bpy.path.abspath(preferences.engine) if preferences else STATE.engine


def choose(context: Context, path: str) -> None:
    """Use the engine at ``path`` from now on; "" is the one that comes with the extension."""
    preferences = settings(context)
    if preferences:
        preferences.engine = path
    STATE.engine = path
    forget()


def interpreter(context: Context) -> str | None:
    """Return the Python of the engine that the user chose; None lets the client find one."""
    path = chosen_path(context)
    if not path:
        return None
    try:
        return checks.find_python(path)
    except S2agError:
        return path  # the client raises an error for it


def is_bundled(context: Context) -> bool:
    """Return whether the engine is the one that comes with the extension, in Blender's own Python."""
    return not chosen_path(context) and not os.environ.get("S2AG_PYTHON")


def facts() -> dict:
    """Return what the last check found (:mod:`core.worker.inventory`); empty before the first."""
    return STATE.facts or {}


def has_recogniser(context: Context) -> bool | None:
    """Return whether the engine can recognise speech; None where that is unknown before the first check."""
    if not facts() and is_bundled(context):
        return optional_packages.has_recogniser()  # that engine runs in this Python
    return facts().get("recogniser")


def forget() -> None:
    """Forget what the last check found."""
    STATE.facts, STATE.error = None, None
