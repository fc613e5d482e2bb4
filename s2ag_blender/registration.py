"""Registers all classes and properties in one order; unregisters them in reverse."""

from types import ModuleType
from typing import Any

import bpy

from . import translations
from .ui import (
    bone_check,
    bone_maps,
    command,
    decisions,
    directing,
    drop,
    engine_ops,
    from_here,
    gesture_assets,
    gesture_panel,
    handlers,
    idle,
    import_motion,
    learn,
    marks,
    menus,
    operators,
    panel,
    preferences,
    presets,
    properties,
    sidebar,
    subpanels,
    take_ops,
    try_it,
    version_ops,
)


def classes_of(module: ModuleType) -> list[type]:
    """Return the classes of ours that Blender knows and that ``module`` defines, in its order."""
    own = [one for one in vars(module).values() if isinstance(one, type) and one.__module__ == module.__name__]
    return [one for one in own if one.__name__.startswith("S2AG_")]


MODULES = (
    preferences,
    properties,
    operators,
    try_it,
    marks,
    bone_maps,
    bone_check,
    take_ops,
    directing,
    from_here,
    version_ops,
    learn,
    import_motion,
    idle,
    gesture_assets,
    panel,
    subpanels,
    gesture_panel,
    decisions,
    menus,
    sidebar,
    engine_ops,
    presets,
    drop,
)
"""Modules with classes, in the order in which they are registered: property groups before what points to them."""
CLASSES = [cls for module in MODULES for cls in classes_of(module)]
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
