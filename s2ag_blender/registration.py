"""Registration in one ordered list; unregistration is its exact reverse."""

import bpy

from . import command, drop, engine_ops, operators, panel, preferences, presets, properties, translations

CLASSES = (
    preferences.S2AG_Preferences,
    properties.S2AG_BoneChoice,
    properties.S2AG_Take,
    properties.S2AG_Session,
    properties.S2AG_Settings,
    operators.S2AG_OT_generate,
    operators.S2AG_OT_cancel,
    operators.S2AG_OT_add_human,
    operators.S2AG_OT_add_mannequin,
    panel.S2AG_PT_gestures,
    *engine_ops.CLASSES,
    *presets.CLASSES,
    *drop.CLASSES,
)
SYSTEMS = (translations, presets, command)
"""Modules with parts of Blender that are no classes: tables of words, folders of presets, commands."""


def register():
    """Register every class and the per-character settings."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.s2ag = bpy.props.PointerProperty(type=properties.S2AG_Settings)
    bpy.types.VIEW3D_MT_armature_add.append(panel.draw_add_menu)
    for system in SYSTEMS:
        system.register()


def unregister():
    """Undo :func:`register` and stop the engine."""
    engine_ops.stop()
    operators.stop_engine()
    for system in reversed(SYSTEMS):
        system.unregister()
    bpy.types.VIEW3D_MT_armature_add.remove(panel.draw_add_menu)
    del bpy.types.Object.s2ag
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
