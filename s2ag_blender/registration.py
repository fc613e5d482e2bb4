"""Registration in one ordered list; unregistration is its exact reverse."""

import bpy

from . import learn, operators, panel, preferences, properties

CLASSES = (
    preferences.S2AG_Preferences,
    properties.S2AG_Settings,
    operators.S2AG_OT_generate,
    operators.S2AG_OT_cancel,
    operators.S2AG_OT_add_human,
    operators.S2AG_OT_add_mannequin,
    learn.S2AG_OT_learn,
    panel.S2AG_PT_gestures,
)


def register():
    """Register every class and the per-character settings."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.s2ag = bpy.props.PointerProperty(type=properties.S2AG_Settings)
    bpy.types.VIEW3D_MT_armature_add.append(panel.draw_add_menu)


def unregister():
    """Undo :func:`register` and stop the engine."""
    operators.stop_engine()
    bpy.types.VIEW3D_MT_armature_add.remove(panel.draw_add_menu)
    del bpy.types.Object.s2ag
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
