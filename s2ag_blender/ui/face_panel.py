"""The panel of a character's face: whether gestures move it, how much, and what it can show."""

import bpy

from ..keys import faces
from ..translations import told
from .subpanels import _Below, character


class S2AG_PT_face(_Below, bpy.types.Panel):
    bl_label = "Face"
    bl_idname = "S2AG_PT_face"

    def draw_header(self, context):
        self.layout.prop(character(context).s2ag, "face", text="")

    def draw_settings(self, layout, armature, settings, context):
        found = faces.find(armature)
        if found is None:
            layout.label(text="No shape keys that speak were found", icon="INFO")
        else:
            layout.label(text=found.shapes.family, icon="CHECKMARK", translate=False)
            missing = [told(part) for part in found.shapes.missing()]
            if missing:
                layout.label(text=told("Nothing for: {parts}", parts=", ".join(missing)), icon="INFO", translate=False)
        column = layout.column()
        column.active = settings.face
        column.prop(settings, "face_intensity", slider=True)
        column.prop(settings, "face_smoothness", slider=True)


CLASSES = (S2AG_PT_face,)
