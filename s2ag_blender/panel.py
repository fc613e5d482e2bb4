"""The sidebar panel: what goes in, one button, and what happens."""

import bpy

from ..core.styles import AFFECTS
from . import operators, properties


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
        self._draw_affect(layout, settings)
        column = layout.column(align=True)
        column.prop(settings, "seed")
        column.prop(settings, "start_frame")
        column = layout.column(heading="Options")
        column.prop(settings, "mirror")
        column.prop(settings, "add_sound")
        self._draw_run(layout)

    @staticmethod
    def _draw_affect(layout, settings):
        header, body = layout.panel("s2ag_affect")
        header.label(text="Affect")
        if body is None:
            return
        known = properties.control_names()
        affect, gestures = body.column(align=True), body.column(align=True)
        for name in AFFECTS:
            affect.prop(settings, name, slider=True)
        gestures.prop(settings, "intensity", slider=True)
        steered = gestures.column(align=True)
        for name in ("rate", "hand"):
            steered.prop(settings, name, slider=True)
        # Greyed, not locked: whoever opens a file whose sliders are set must be able to set them back.
        affect.active = steered.active = bool(known)
        if not known:
            body.label(text="This checkpoint has intensity only", icon="INFO")

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
