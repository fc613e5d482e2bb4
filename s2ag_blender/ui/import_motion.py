"""Operator that applies a motion file, captured or made by another program, to the active character; needs no engine."""
# pyright: reportInvalidTypeForm=false

from collections.abc import Callable
from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from ..datablocks import ArmatureObject, Context
from ..keys import apply
from ..rig import chosen_bones
from ..takes import drafts, stored_settings
from ..translations import translate
from .bases import LayoutMixin, OfCharacter, require_character


def apply_motion_file(
    armature: ArmatureObject, path: str | Path, start: int | None = None, mirror: bool = False,
    report: Callable[[str], None] | None = None
) -> bpy.types.Action:  # fmt: skip
    """Key a motion file on ``armature`` from frame ``start`` (None: the scene's first) with its settings; return the action.

    ``report`` is called with each warning. Raises :class:`S2agError` before anything is changed."""
    from ...core.motion.readers import motion_files  # registering needs none of it

    motion = motion_files.load(path)
    settings = armature.s2ag
    return apply.apply_motion(
        armature,
        motion.mirrored() if mirror else motion,
        start,
        mapping=chosen_bones.mapping_of_settings(settings),
        options=stored_settings.options(settings),
        name=f"{armature.name} {Path(path).stem}",
        report=report,
    )


class S2AG_OT_import_motion(OfCharacter, bpy.types.Operator, ImportHelper):
    """Let the character perform a motion file: one of ours, a BVH file or SMPL-X poses"""

    bl_label = "Perform Motion File"

    filter_glob: bpy.props.StringProperty(default="*.npz;*.bvh", options={"HIDDEN"})
    at_playhead: bpy.props.BoolProperty(
        name="From the Playhead", description="Begin at the current frame instead of the scene's first"
    )
    mirror: bpy.props.BoolProperty(name="Mirror", description="Exchange left and right")

    def work(self, context: Context) -> str:
        armature = require_character(context)
        warnings: list[str] = []
        drafts.drop(armature)
        start = context.scene.frame_current if self.at_playhead else None
        action = apply_motion_file(armature, bpy.path.abspath(self.filepath), start, self.mirror, warnings.append)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return translate("{name} performs {file}", name=armature.name, file=action.name)


def draw_in_import(self: LayoutMixin, context: Context) -> None:
    """Draw the entry in the menu File > Import."""
    self.layout.operator(S2AG_OT_import_motion.bl_idname, text="Gesture Motion (.npz, .bvh)")


def register() -> None:
    """Add the entry to the menu."""
    bpy.types.TOPBAR_MT_file_import.append(draw_in_import)


def unregister() -> None:
    """Remove the entry from the menu."""
    bpy.types.TOPBAR_MT_file_import.remove(draw_in_import)
