"""Base classes of the operators with long work, and of those among them that generate gestures."""

from __future__ import annotations  # names of modules that have not run yet

from collections.abc import Generator
from typing import TYPE_CHECKING, Any, cast

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context, is_armature
from ..translations import translate, translate_error
from . import generate, session

TICK = 0.01
"""Seconds between polls of the engine."""
_OF_THE_VIEW = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE"}


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


class ModalOperator:
    """Base of operators with long work: modal with a window, to completion in background mode."""

    bl_options = {"REGISTER", "UNDO"}
    shares_events = True
    """Whether Blender can be used meanwhile; else nothing but the view can be changed."""
    _timer = cast("bpy.types.Timer | None", None)
    _run = cast("session.Run | session.SlicedRun | None", None)
    if TYPE_CHECKING:
        report: Any

    def begun(self, context: Context) -> session.Run | session.SlicedRun:
        """Begin the work and return its run; may raise :class:`S2agError`."""
        raise NotImplementedError

    def finished(self, outcome: Any) -> Any:
        """Report the outcome of the run and return the operator's result."""
        raise NotImplementedError

    def failed(self, error: S2agError) -> Any:
        """Report the error with which the run ended and return the operator's result."""
        raise NotImplementedError

    def execute(self, context: Context) -> Any:
        """Run to completion."""
        raise NotImplementedError

    def invoke(self, context: Context, event: bpy.types.Event) -> Any:
        """Start in the background; without a window, run to completion."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            self._run = self.begun(context)
        except S2agError as error:
            return self.failed(error)
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        announce(context, self._run)
        context.window_manager.modal_handler_add(cast(bpy.types.Operator, self))
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: bpy.types.Event) -> Any:
        """Go on with the work on every tick; ESC cancels."""
        run, goes_on = self._run, {"PASS_THROUGH" if self.shares_events or event.type in _OF_THE_VIEW else "RUNNING_MODAL"}
        assert run is not None
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
        elif event.type != "TIMER":
            return goes_on
        before = run.text, run.value
        try:
            outcome = run.step()
        except S2agError as error:
            self._stop(context)
            return self.failed(error)
        except BaseException:
            self._stop(context)
            raise
        if outcome is None:
            if before != (run.text, run.value):
                announce(context, run)
                redraw(context)
            return goes_on
        self._stop(context)
        return self.finished(outcome)

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


class SlicedOperator(ModalOperator):
    """Base of operators whose work is done in slices, which subclasses give."""

    def slices(self, context: Context) -> Generator[float | None, None, Any]:
        """Return the work, which yields the share that is done and ends with what :meth:`finished` takes."""
        raise NotImplementedError

    def begun(self, context: Context) -> session.SlicedRun:
        return session.SlicedRun(self.slices(context), translate(cast(Any, self).bl_label))

    def execute(self, context: Context) -> Any:
        from ...rigs.slices import run_to_end  # registering is to run nothing of rigs

        try:
            return self.finished(run_to_end(self.slices(context)))
        except S2agError as error:
            return self.failed(error)

    def failed(self, error: S2agError) -> Any:
        told = ("INFO", translate("Cancelled")) if error.kind == "Cancelled" else ("ERROR", translate_error(error))
        self.report({told[0]}, told[1])
        return {"CANCELLED"}


class GeneratingOperator(ModalOperator):
    """Base of operators that generate gestures; subclasses override :meth:`planned`.

    Nothing in the file changes before everything is finished, and then in one undo step."""

    def planned(self, context: Context, armature: ArmatureObject) -> generate.Plan:
        """Return the plan of what to generate."""
        return generate.plan(context, armature)

    def execute(self, context: Context) -> Any:
        try:
            return self.finished(generate.wait(context, self.planned(context, self._acting(context))))
        except S2agError as error:
            return self.failed(error)

    def begun(self, context: Context) -> session.Run:
        armature = self._acting(context)
        return session.Run(context, armature, self.planned(context, armature))

    def _acting(self, context: Context) -> ArmatureObject:
        """Return the character, whose messages of before are dropped; a poll has made sure that there is one."""
        armature = character(context)
        assert armature is not None
        self._uid, self._name = armature.session_uid, armature.name
        session.ERRORS.pop(self._uid, None)
        return armature

    def finished(self, outcome: generate.Outcome) -> Any:
        for warning in outcome.warnings:
            self.report({"WARNING"}, translate(warning))
        made = translate("{name} gestures for {seconds:.1f} seconds", name=self._name, seconds=outcome.seconds)
        self.report({"INFO"}, ". ".join([outcome.said or made, *outcome.notes]))  # as rows they would move all below them
        return {"FINISHED"}

    def failed(self, error: S2agError) -> Any:
        if error.kind == "Cancelled":
            self.report({"INFO"}, translate("Cancelled"))
            return {"CANCELLED"}
        session.fail(self._uid, error)
        self.report({"ERROR"}, translate_error(error))
        return {"CANCELLED"}


def announce(context: Context, run: session.Run | session.SlicedRun | None) -> None:
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
