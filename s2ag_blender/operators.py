"""Operators: thin, one undo step each. All they do, a script can do through the functions they call."""

from dataclasses import dataclass, field

import bpy

from ..core.errors import S2agError
from . import gesture


@dataclass
class State:
    """What the panel shows of the session; never saved."""

    job: object = None
    stage: str = ""
    value: float = 0.0
    messages: list = field(default_factory=list)

    def say(self, text: str, icon: str) -> None:
        self.messages.append((text, icon))


STATE = State()


def character(context):
    """The armature that the active object is or is deformed by, or None."""
    active = context.active_object
    if active is None or active.type == "ARMATURE":
        return active
    return active.find_armature()


def stop_engine() -> None:
    """End the engine's process, if there is one."""
    STATE.job = None
    gesture.stop_engine()


class S2AG_OT_generate(bpy.types.Operator):
    """Make the character gesture to its recording"""

    bl_idname = "s2ag.generate"
    bl_label = "Generate Gestures"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        armature = character(context)
        if armature is None:
            reason = "Select a character's armature"
        elif STATE.job is not None:
            reason = "Gestures are being made"
        elif not armature.s2ag.audio:
            reason = "Choose a recording"
        else:
            return True
        cls.poll_message_set(reason)
        return False

    def execute(self, context):
        armature = character(context)
        try:
            result = gesture.synthesize(context, armature.s2ag)
            return self._finish(context, armature, result)
        except S2agError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    def invoke(self, context, event):
        self._armature = character(context).name
        STATE.messages.clear()
        STATE.stage, STATE.value = "start", 0.0
        try:
            STATE.job = gesture.start(context, character(context).s2ag)
        except S2agError as error:
            return self._fail(error)
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            gesture.cancel(STATE.job)
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        for area in context.screen.areas:
            area.tag_redraw()
        try:
            result = gesture.poll(STATE.job, self._on_progress)
            if result is None:
                return {"RUNNING_MODAL"}
            self._stop(context)
            armature = bpy.data.objects.get(self._armature)
            if armature is None:
                raise S2agError(f"The character {self._armature} is gone.", "Select it again.")
            return self._finish(context, armature, result)
        except S2agError as error:
            self._stop(context)
            return self._fail(error)

    def cancel(self, context):
        gesture.cancel(STATE.job)
        self._stop(context)

    def _on_progress(self, stage: str, value: float) -> None:
        STATE.stage, STATE.value = stage, value

    def _stop(self, context):
        STATE.job = None
        if getattr(self, "_timer", None):
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None

    def _finish(self, context, armature, result):
        for warning in gesture.key(context, armature, result):
            STATE.say(warning, "ERROR")
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, f"{armature.name} gestures for {result['motions'][0].duration:.1f} seconds")
        return {"FINISHED"}

    def _fail(self, error: S2agError):
        if error.kind == "Cancelled":
            self.report({"INFO"}, "Cancelled")
            return {"CANCELLED"}
        STATE.say(error.message, "ERROR")
        if error.remedy:
            STATE.say(error.remedy, "BLANK1")
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}


class S2AG_OT_cancel(bpy.types.Operator):
    """Stop making gestures; nothing has been changed"""

    bl_idname = "s2ag.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return STATE.job is not None

    def execute(self, context):
        gesture.cancel(STATE.job)
        return {"FINISHED"}


class _AddCharacter:
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            armature = gesture.add_character(self.character, getattr(self, "gender", "female"))
        except S2agError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for selected in context.selected_objects:
            selected.select_set(False)
        armature.select_set(True)
        context.view_layer.objects.active = armature
        return {"FINISHED"}


class S2AG_OT_add_human(_AddCharacter, bpy.types.Operator):
    """Add a person with a skeleton, ready to gesture"""

    bl_idname = "s2ag.add_human"
    bl_label = "Gesturing Human"
    character = "human"

    gender: bpy.props.EnumProperty(name="Gender", items=[("female", "Woman", ""), ("male", "Man", "")])


class S2AG_OT_add_mannequin(_AddCharacter, bpy.types.Operator):
    """Add a plain figure, ready to gesture"""

    bl_idname = "s2ag.add_mannequin"
    bl_label = "Gesturing Mannequin"
    character = "mannequin"
