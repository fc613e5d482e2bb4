"""The sidebar panel: what goes in, one button, and what happens."""

import bpy

from . import operators


class S2AG_PT_gestures(bpy.types.Panel):
    bl_label = "Gestures"
    bl_category = "S2AG"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context):
        layout = self.layout
        armature = operators.character(context)
        if armature is None:
            layout.label(text="Select a character", icon="INFO")
            column = layout.column(align=True)
            column.operator("s2ag.add_human", icon="OUTLINER_OB_ARMATURE")
            column.operator("s2ag.add_mannequin", icon="ARMATURE_DATA")
            return
        settings = armature.s2ag
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.label(text=armature.name, icon="ARMATURE_DATA")
        column = layout.column()
        column.prop(settings, "audio")
        column.prop(settings, "transcript")
        column.prop(settings, "style")
        column = layout.column(align=True)
        column.prop(settings, "intensity", slider=True)
        column.prop(settings, "seed")
        column.prop(settings, "start_frame")
        column = layout.column(heading="Options")
        column.prop(settings, "mirror")
        column.prop(settings, "add_sound")
        self._draw_run(layout)

    @staticmethod
    def _draw_run(layout):
        state = operators.STATE
        if state.job is None:
            row = layout.row()
            row.scale_y = 1.4
            row.operator("s2ag.generate", icon="PLAY")
        else:
            row = layout.row(align=True)
            row.progress(factor=state.value, text=state.stage.capitalize())
            row.operator("s2ag.cancel", text="", icon="X")
        for text, icon in state.messages:
            layout.label(text=text, icon=icon)


def draw_add_menu(self, context):
    """Entries of the Add > Armature menu."""
    self.layout.separator()
    self.layout.operator("s2ag.add_human", icon="OUTLINER_OB_ARMATURE")
    self.layout.operator("s2ag.add_mannequin", icon="ARMATURE_DATA")
