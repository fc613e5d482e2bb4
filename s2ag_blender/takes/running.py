"""The one way in which operators run the engine: modal in a window, to completion without one."""

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context
from ..translations import told, told_error
from . import generate, session

TICK = 0.01
"""Seconds between looks at the engine."""


def character(context: Context) -> bpy.types.Object | None:
    """The armature that the active object is, is deformed by or hangs on; else the only one that is selected; or None.

    Importers leave whatever came last active, an empty below the armature, say.
    """
    active = context.active_object or context.view_layer.objects.active  # a hidden one is still the chosen one
    found = armature_of(active)
    if found is None and active is not None:
        chosen = [item for item in getattr(context, "selected_objects", ()) if item.type == "ARMATURE"]
        found = chosen[0] if len(chosen) == 1 else None
    return found


def armature_of(item: bpy.types.Object | None) -> bpy.types.Object | None:
    """The armature that an object is, is deformed by or hangs on, or None."""
    while item is not None and item.type != "ARMATURE":
        deforming = item.find_armature()
        if deforming is not None:
            return deforming
        item = item.parent
    return item


class Generating:
    """Base of operators that make gestures; they say with ``planned(context, armature)`` which.

    Nothing in the file changes before all is done, and then in one undo step.
    """

    bl_options = {"REGISTER", "UNDO"}
    _timer = None
    _run = None

    def planned(self, context: Context, armature: ArmatureObject) -> generate.Plan:
        """What to make."""
        return generate.plan(context, armature)

    def execute(self, context: Context):
        """Run to completion."""
        armature = character(context)
        session.MESSAGES.pop(armature.session_uid, None)
        try:
            outcome = generate.wait(context, self.planned(context, armature))
        except S2agError as error:
            return self._fail(armature.session_uid, error)
        return self._done(armature.session_uid, armature.name, outcome)

    def invoke(self, context: Context, event: bpy.types.Event):
        """Start and come back to the user; without a window, run to completion."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        armature = character(context)
        self._uid, self._name = armature.session_uid, armature.name
        session.MESSAGES.pop(self._uid, None)
        try:
            self._run = session.Run(context, armature, self.planned(context, armature))
        except S2agError as error:
            return self._fail(self._uid, error)
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        announce(context, self._run)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: bpy.types.Event):
        """Look at the engine on every tick; ESC cancels."""
        if event.type == "ESC" and event.value == "PRESS":
            self._run.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        before = self._run.stage, self._run.value
        try:
            outcome = self._run.step()
        except S2agError as error:
            self._stop(context)
            return self._fail(self._uid, error)
        except BaseException:
            self._stop(context)
            raise
        if outcome is None:
            if before != (self._run.stage, self._run.value):
                announce(context, self._run)
                redraw(context)
            return {"PASS_THROUGH"}
        self._stop(context)
        return self._done(self._uid, self._name, outcome)

    def cancel(self, context: Context):
        """Blender ends the operator: another file is opened, or the window closes."""
        if self._run is not None:
            self._run.cancel()
        self._stop(context)

    def _stop(self, context: Context) -> None:
        if self._run is not None:
            self._run.end()
        announce(context, None)
        redraw(context)
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None

    def _done(self, uid: int, name: str, outcome: generate.Outcome):
        session.MESSAGES[uid] = [(note, "INFO") for note in outcome.notes]  # warnings stand with their take
        for warning in outcome.warnings:
            self.report({"WARNING"}, told(warning))
        self.report({"INFO"}, told("{name} gestures for {seconds:.1f} seconds", name=name, seconds=outcome.seconds))
        return {"FINISHED"}

    def _fail(self, uid: int, error: S2agError):
        if error.kind == "Cancelled":
            self.report({"INFO"}, told("Cancelled"))
            return {"CANCELLED"}
        session.fail(uid, error)
        self.report({"ERROR"}, told_error(error))
        return {"CANCELLED"}


def announce(context: Context, run: session.Run | None) -> None:
    """Tell in the status bars of all windows what a run is at, wherever it was started; None gives them back."""
    text = run and told("{stage} ({share:.0%}), Esc cancels", stage=run.text, share=run.value)
    for window in context.window_manager.windows:
        window.workspace.status_text_set(text)


def redraw(context: Context) -> None:
    """Draw the sidebars of all 3D viewports anew, and not the viewports themselves."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()
