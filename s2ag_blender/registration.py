"""Registers all classes and properties in one ordered list; unregisters them in reverse."""

from typing import Any  # noqa: I001 - packed below

import bpy

from . import translations
from .ui import (
    bone_check, bone_maps, command, decisions, directing, drop, engine_ops, from_here, gesture_assets, gesture_panel,
    handlers, idle, import_motion, learn, marks, menus, operators, panel, preferences, presets, properties, sidebar,
    subpanels, take_ops, try_it, version_ops,
)  # fmt: skip

CLASSES = (
    preferences.S2AG_Preferences, properties.S2AG_BoneChoice, properties.S2AG_Version, properties.S2AG_Take,
    properties.S2AG_Session, properties.S2AG_Settings, operators.S2AG_OT_generate, operators.S2AG_OT_cancel,
    operators.S2AG_OT_add_human, operators.S2AG_OT_add_mannequin, try_it.S2AG_OT_try_it, operators.S2AG_OT_remove_markers,
    operators.S2AG_OT_export, marks.S2AG_OT_insert_mark, *bone_maps.CLASSES, *bone_check.CLASSES, *take_ops.CLASSES,
    *directing.CLASSES, *from_here.CLASSES, *version_ops.CLASSES, learn.S2AG_OT_learn, import_motion.S2AG_OT_import_motion,
    idle.S2AG_OT_idle, *gesture_assets.CLASSES, panel.S2AG_PT_gestures, *subpanels.CLASSES, *gesture_panel.CLASSES,
    *decisions.CLASSES, *menus.CLASSES, *sidebar.CLASSES, *engine_ops.CLASSES, *presets.CLASSES, *drop.CLASSES,
)  # fmt: skip
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
