"""Operators that learn from animation, which becomes training data or a style, and from films, which become takes."""
# pyright: reportInvalidTypeForm=false

from collections.abc import Generator
from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import UsageError
from .. import provenance
from ..datablocks import Context, current_context
from ..engine import engine_state
from ..takes import drafts, learning, menu_items, sound_strips, sources, take_list
from ..takes.operator_base import SlicedOperator
from ..translations import translate
from . import import_motion
from .bases import NeedsCharacter, OfCharacter, OperatorResult, require_character


class S2AG_OT_learn(NeedsCharacter, bpy.types.Operator):
    """Save what this character does, with its speech, into a folder from which a network can be trained"""

    bl_label = "Learn from This Action"
    bl_options = {"REGISTER"}

    directory: bpy.props.StringProperty(name="Folder", description="Folder of takes", subtype="DIR_PATH")

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        armature = require_character(context)
        if armature.mode == "EDIT":
            return translate("Leave edit mode first")
        if not learning.is_animated(armature):
            return translate("The character has no animation to learn from")
        return sources.missing_inputs(armature.s2ag, context.scene)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: Context) -> str:
        armature = require_character(context)
        drafts.drop(armature)  # a draft is no animation of the user's
        path = learning.save_take(armature, bpy.path.abspath(self.directory), **learning.speech_of(armature, context.scene))
        if not bpy.app.background and context.window is not None:
            cast(Any, bpy.ops).s2ag.own_style("INVOKE_DEFAULT", filepath=str(path))  # scripts decide that for themselves
        return translate("{name} is saved; train with: s2ag data plain", name=path.name)


class _FromFile(SlicedOperator, NeedsCharacter):
    """Base of operators that let the engine work on a file, which is chosen first."""

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        if self.filepath:
            return super().invoke(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> OperatorResult:
        if not bpy.app.background and context.window is not None:
            button = getattr(cast(Any, bpy.ops).s2ag, self.bl_idname.removeprefix("S2AG_OT_"))
            return button("INVOKE_DEFAULT", filepath=self.filepath)
        return super().execute(context)

    def finished(self, outcome: str) -> OperatorResult:
        self.report({"INFO"}, outcome)
        return {"FINISHED"}


class S2AG_OT_own_style(_FromFile, bpy.types.Operator):
    """Add a style of your own to the menu: one that was learned, or one to learn from a motion file of somebody who talks"""

    bl_label = "Style from File"

    filter_glob: bpy.props.StringProperty(default="*.json;*.npz;*.bvh", options={"HIDDEN"})

    def slices(self, context: Context) -> Generator[float, None, str]:
        settings = require_character(context).s2ag
        weights = menu_items.speakers_and_controls(settings).get("hash", "")
        python = engine_state.interpreter(context)
        name = yield from learning.style_in_slices(bpy.path.abspath(self.filepath), weights, python)
        require_character(current_context()).s2ag.style_pick = name
        return translate("The style {name} is in the menu", name=name)


class S2AG_OT_capture_film(OfCharacter, _FromFile, bpy.types.Operator):
    """Take the motion of a person from a film, with its sound, as a take; Escape stops, the same film goes on from there"""

    bl_label = "Capture from Film"

    filter_glob: bpy.props.StringProperty(default="*.mp4;*.mov;*.mkv;*.webm;*.avi;*.m4v", options={"HIDDEN"})

    def slices(self, context: Context) -> Generator[float, None, str]:
        film = Path(bpy.path.abspath(self.filepath))
        path = film.with_name(f"{film.stem} captured.npz")
        command = ["capture", str(film), "-o", str(path)]
        notes = yield from learning.command_in_slices(command, engine_state.interpreter(context))
        if reason := self.why_not(current_context()):
            raise UsageError(reason)
        armature, scene = require_character(current_context()), current_context().scene
        drafts.drop(armature)
        action = import_motion.apply_motion_file(armature, path, None, False, notes.append)
        place = {"result": "ACTION", "first": round(action.frame_range[0]), "last": round(action.frame_range[1])}
        provenance.stamp(action, {**provenance.require(action), "place": place})
        if (sound := path.with_suffix(".wav")).is_file():
            tag, news = sound_strips.add_strip(scene, str(sound), scene.frame_start, path.stem, armature.s2ag.add_sound)
            action[sound_strips.TAG], notes = tag, notes + news
        take_list.add_takes(armature, [action], path.stem, notes)
        return translate("{name} performs {file}", name=armature.name, file=action.name)
