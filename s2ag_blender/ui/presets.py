"""Presets of a character's settings, in Blender's own preset system; the shipped ones are files in ``presets/``."""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..datablocks import Context
from ..takes.operator_base import character
from ..translations import translate
from . import setting_properties
from .bases import Button

LABEL = "Gesture Presets"
FOLDER = "s2ag/character"
"""Folder below ``presets`` in every place where Blender looks for presets."""
SETTINGS = "settings = bpy.context.window_manager.s2ag.settings"
VALUES = (
    *setting_properties.PRESETS, "style_second", "style_mix", "speed", "smoothing",
    "torso_strength", "head_strength", "clavicle_strength", "palms",
)  # fmt: skip
"""Properties that a preset sets: those of style and body, none of the recording, the frames or the layers."""

_ROOT = str(Path(__file__).parents[2])


class S2AG_OT_preset_add(AddPresetBase, Button, bpy.types.Operator):
    """Keep how this character gestures as a preset, or remove the preset"""

    bl_label = "Add Gesture Preset"
    preset_menu = "S2AG_PT_presets"
    preset_subdir = FOLDER
    preset_defines = [SETTINGS]
    preset_values = [f"settings.{name}" for name in VALUES]

    @classmethod
    def why_not(cls, context: Context) -> str:
        return translate("Select a character") if character(context) is None else ""


class S2AG_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = LABEL
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "s2ag.preset_add"


def register() -> None:
    """Register the folder of the shipped presets."""
    S2AG_PT_presets.bl_label = LABEL  # Blender sets it to the name of the last preset that was used
    bpy.utils.register_preset_path(_ROOT)


def unregister() -> None:
    """Undo :func:`register`."""
    bpy.utils.unregister_preset_path(_ROOT)
