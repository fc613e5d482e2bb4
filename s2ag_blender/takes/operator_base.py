"""Base class of the operators that run the engine: modal with a window, to completion in background mode."""

from __future__ import annotations  # names of modules that have not run yet

from typing import TYPE_CHECKING, Any, cast

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context, is_armature
from ..translations import translate, translate_error
from . import generate, session

TICK = 0.01
"""Seconds between polls of the engine."""


def character(context: Context) -> ArmatureObject | None:
    """Return the armature of the active object (see :func:`armature_of`), else the only selected one, or None.

    Importers may leave another object active, such as an empty that is a child of the armature."""
    active = context.active_object or context.view_layer.objects.active  # hidden objects are not context.active_object
    armature = armature_of(active)
    if armature is None and active is not None:
        chosen = [item for item in getattr(context, "selected_objects", ()) if item.type == "ARMATURE"]
        armature = chosen[0] if len(chosen) == 1 else None
    return armature


def armature_of(item: bpy.types.Object | None) -> ArmatureObject | None:
    """Return the armature that an object is, is deformed by, or is a child of, or None."""
    while item is not None and not is_armature(item):
        deforming = item.find_armature()
        if deforming is not None:
            return cast(ArmatureObject, deforming)
        item = item.parent
    return cast("ArmatureObject | None", item)


def _chosen(context: Context) -> ArmatureObject:
    """Return :func:`character`, which an operator's poll has checked."""
    armature = character(context)
    assert armature is not None
    return armature


class GeneratingOperator:
    """Base of operators that generate gestures; subclasses override :meth:`planned`.

    Nothing in the file changes before everything is finished, and then in one undo step."""

    bl_options = {"REGISTER", "UNDO"}
    _timer = cast("bpy.types.Timer | None", None)
    _run = cast("session.Run | None", None)
    if TYPE_CHECKING:
        report: Any

    def planned(self, context: Context, armature: ArmatureObject) -> generate.Plan:
        """Return the plan of what to generate."""
        return generate.plan(context, armature)

    def execute(self, context: Context) -> Any:
        """Run to completion."""
        armature = _chosen(context)
        session.MESSAGES.pop(armature.session_uid, None)
        try:
            outcome = generate.wait(context, self.planned(context, armature))
        except S2agError as error:
            return self._fail(armature.session_uid, error)
        return self._done(armature.session_uid, armature.name, outcome)

    def invoke(self, context: Context, event: bpy.types.Event) -> Any:
        """Start in the background; without a window, run to completion."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        armature = _chosen(context)
        self._uid, self._name = armature.session_uid, armature.name
        session.MESSAGES.pop(self._uid, None)
        try:
            self._run = session.Run(context, armature, self.planned(context, armature))
        except S2agError as error:
            return self._fail(self._uid, error)
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        announce(context, self._run)
        context.window_manager.modal_handler_add(cast(bpy.types.Operator, self))
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: bpy.types.Event) -> Any:
        """Poll the engine on every tick; ESC cancels."""
        run = self._run
        assert run is not None
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        before = run.stage, run.value
        try:
            outcome = run.step()
        except S2agError as error:
            self._stop(context)
            return self._fail(self._uid, error)
        except BaseException:
            self._stop(context)
            raise
        if outcome is None:
            if before != (run.stage, run.value):
                announce(context, run)
                redraw(context)
            return {"PASS_THROUGH"}
        self._stop(context)
        return self._done(self._uid, self._name, outcome)

    def cancel(self, context: Context) -> None:
        """Stop when Blender ends the operator, because another file is opened or the window closes."""
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

    def _done(self, uid: int, name: str, outcome: generate.Outcome) -> Any:
        session.MESSAGES[uid] = [(note, "INFO") for note in outcome.notes]  # warnings are stored with their take
        for warning in outcome.warnings:
            self.report({"WARNING"}, translate(warning))
        made = translate("{name} gestures for {seconds:.1f} seconds", name=name, seconds=outcome.seconds)
        self.report({"INFO"}, outcome.said or made)
        return {"FINISHED"}

    def _fail(self, uid: int, error: S2agError) -> Any:
        if error.kind == "Cancelled":
            self.report({"INFO"}, translate("Cancelled"))
            return {"CANCELLED"}
        session.fail(uid, error)
        self.report({"ERROR"}, translate_error(error))
        return {"CANCELLED"}


def announce(context: Context, run: session.Run | None) -> None:
    """Show the progress of a run in the status bars of all windows; None clears them."""
    text = run and translate("{stage} ({share:.0%}), Esc cancels", stage=run.text, share=run.value)
    for window in context.window_manager.windows:
        window.workspace.status_text_set(text)


def redraw(context: Context) -> None:
    """Redraw the sidebars of all 3D viewports, but not the viewports themselves."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()
