"""Menus with the operators of the panel, so that search (F3) finds them."""

import bpy

from ..datablocks import Context
from ..takes.operator_base import character
from .bases import Icon, LayoutMixin

_MORE_TAKES: tuple[tuple[str, Icon], ...] = (("reroll", "FILE_REFRESH"), ("vary", "MOD_NOISE"), ("style_grid", "MESH_GRID"))
"""Operators that make more takes, with icons."""
_BODIES: tuple[tuple[str, Icon], ...] = (("idle", "USER"), ("generate_strips", "SEQUENCE"), ("insert_gesture", "VIEW_PAN"))


class S2AG_MT_gestures(LayoutMixin, bpy.types.Menu):
    bl_idname = "S2AG_MT_gestures"
    bl_label = "Gestures"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.operator("s2ag.choose_recording", icon="FILE_SOUND")
        layout.operator("s2ag.generate", icon="PLAY")
        layout.prop(context.window_manager.s2ag, "live")
        layout.separator()
        for name, icon in _MORE_TAKES:
            layout.operator(f"s2ag.{name}", icon=icon)
        layout.separator()
        for name in ("keep_take", "delete_take", "delete_others", "recall_take", "change_keys"):
            layout.operator(f"s2ag.{name}")
        layout.separator()
        for name in ("show_markers", "apply_markers", "add_gesture", "add_at_word", "change_gesture", "delete_gesture"):
            layout.operator(f"s2ag.{name}")
        layout.operator_menu_enum("s2ag.reroll_range", "what")
        layout.operator_menu_enum("s2ag.style_from", "style")
        layout.operator_menu_enum("s2ag.feeling_from", "mood")
        layout.operator_menu_enum("s2ag.mark_style", "style")
        layout.operator_menu_enum("s2ag.keep_pose", "what")
        for name in ("keep_place", "follow_sound", "flip_version", "drop_versions"):
            layout.operator(f"s2ag.{name}")
        layout.separator()
        for name in ("edit_bone_map", "reset_bone_map", "load_bone_map", "save_bone_map", "select_bones", "test_pose"):
            layout.operator(f"s2ag.{name}")
        for name in ("load_face_map", "save_face_map", "reset_face_map"):
            layout.operator(f"s2ag.{name}")
        layout.operator_menu_enum("s2ag.bones_from_selection", "part")
        layout.separator()
        layout.operator("s2ag.fit_range")
        layout.operator("s2ag.remove_markers")
        layout.operator_menu_enum("s2ag.export", "format", icon="EXPORT")
        layout.operator("s2ag.import_motion", icon="IMPORT")
        for name, icon in _BODIES:
            layout.operator(f"s2ag.{name}", icon=icon)
        layout.operator("s2ag.save_gesture", icon="ASSET_MANAGER")
        for name in ("capture_film", "learn", "own_style"):
            layout.operator(f"s2ag.{name}")


def draw_in_animation(self: LayoutMixin, context: Context) -> None:
    """Draw the entries in the menu Object > Animation, which is also Pose > Animation."""
    self.layout.separator()
    self.layout.operator("s2ag.show_panel", icon="OUTLINER_OB_ARMATURE")
    if character(context) is not None:
        self.layout.menu(S2AG_MT_gestures.bl_idname)


def draw_in_add(self: LayoutMixin, context: Context) -> None:
    """Draw the entries in the menu Add > Armature."""
    self.layout.separator()
    self.layout.operator("s2ag.add_human", icon="OUTLINER_OB_ARMATURE")
    self.layout.operator("s2ag.add_mannequin", icon="ARMATURE_DATA")


def draw_in_assets(self: LayoutMixin, context: Context) -> None:
    """Draw the button for a chosen action, in the header of an asset browser, which has no F3, and by a right click."""
    if getattr(getattr(context, "asset", None), "id_type", "") == "ACTION":
        self.layout.operator("s2ag.insert_gesture", icon="VIEW_PAN")


def register() -> None:
    """Add the menu entries."""
    bpy.types.ASSETBROWSER_MT_context_menu.prepend(draw_in_assets)
    bpy.types.ASSETBROWSER_MT_editor_menus.append(draw_in_assets)
    bpy.types.VIEW3D_MT_armature_add.append(draw_in_add)
    bpy.types.VIEW3D_MT_object_animation.append(draw_in_animation)


def unregister() -> None:
    """Undo :func:`register`."""
    bpy.types.VIEW3D_MT_object_animation.remove(draw_in_animation)
    bpy.types.VIEW3D_MT_armature_add.remove(draw_in_add)
    bpy.types.ASSETBROWSER_MT_editor_menus.remove(draw_in_assets)
    bpy.types.ASSETBROWSER_MT_context_menu.remove(draw_in_assets)
