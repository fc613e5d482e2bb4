"""Registers all classes and properties in one order; unregisters them in reverse."""

import importlib
import pkgutil
from types import ModuleType
from typing import Any

import bpy

from . import translations, ui
from .ui import command, engine_ops, handlers, import_motion, menus, presets, properties

FIRST = "preferences", "properties", "panel", "subpanels", "gesture_panel"
"""Files of ``ui`` whose classes those of other files point to, in the order in which they are registered."""


def _modules() -> list[ModuleType]:
    """Return all modules of ``ui``."""
    others = {one.name for one in pkgutil.iter_modules(ui.__path__)} - set(FIRST)
    return [importlib.import_module(f".{name}", ui.__name__) for name in (*FIRST, *sorted(others))]


def classes_of(module: ModuleType) -> list[type]:
    """Return the classes of ours that Blender knows and that ``module`` defines, in its order."""
    own = [one for one in vars(module).values() if isinstance(one, type) and one.__module__ == module.__name__]
    return [one for one in own if one.__name__.startswith("S2AG_")]


CLASSES = [cls for module in _modules() for cls in classes_of(module)]
SYSTEMS = (translations, presets, command, menus, import_motion, handlers)
"""Modules that register what is no class: translations, preset folders, commands, menu entries, handlers."""
_OBJECT: Any = bpy.types.Object
_WINDOW_MANAGER: Any = bpy.types.WindowManager


def register() -> None:
    """Register every class, the settings of characters and the state of the session."""
    for cls in CLASSES:
        translations.set_translation_context(cls)
        bpy.utils.register_class(cls)
    _OBJECT.s2ag = bpy.props.PointerProperty(type=properties.S2AG_Settings, override={"LIBRARY_OVERRIDABLE"})
    _WINDOW_MANAGER.s2ag = bpy.props.PointerProperty(type=properties.S2AG_Session)
    for system in SYSTEMS:
        system.register()


def unregister() -> None:
    """Undo :func:`register` and stop the engine."""
    engine_ops.stop()
    for system in reversed(SYSTEMS):
        system.unregister()
    engine_ops.stop_engine()
    del _WINDOW_MANAGER.s2ag
    del _OBJECT.s2ag
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
