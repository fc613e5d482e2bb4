"""Operators for the engine: choose a Python with the full engine, check it, return to the one that comes with the extension."""
# pyright: reportInvalidTypeForm=false

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy

from ...core.errors import S2agError
from ...core.worker import interpreter
from ..datablocks import Context, current_context
from ..engine import client, engine_state, errors_log
from ..lazy_modules import has_run
from ..takes import engine_requests
from ..takes.operator_base import redraw
from ..translations import translate, translate_error
from .bases import Button, OperatorMixin, OperatorResult

_README = Path(__file__).parents[2] / "README.md"


def begin(context: Context, path: str = "") -> interpreter.Check:
    """Start checking the engine at ``path``, which is used from then on if it works, or the one in use; return at once.

    Call :func:`tick` until it returns False. Raises :class:`S2agError` if there is no such engine."""
    chosen = interpreter.find_python(path) if path else engine_state.interpreter(context)
    python = client.find_interpreter(chosen)
    engine_state.STATE.error = None
    engine_state.STATE.work, engine_state.STATE.chosen = interpreter.Check(python if client.is_chosen(chosen) else None), path
    return engine_state.STATE.work


def check(context: Context, path: str = "") -> dict:
    """Check as :func:`begin` does, and wait; return the engine's facts or raise the :class:`S2agError` it failed with."""
    work = begin(context, path)
    try:
        return work.wait()
    finally:
        _finish(context)


def tick() -> bool:
    """Poll the check under way; return True while it goes on."""
    work = engine_state.STATE.work
    if work is None:
        return False
    context = current_context()
    is_running = not work.poll()
    if not is_running:
        _finish(context)
    redraw(context)
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PREFERENCES":
                area.tag_redraw()
    return is_running


def stop() -> None:
    """Cancel the check under way."""
    if engine_state.STATE.work is not None:
        engine_state.STATE.work.cancel()
        tick()


def stop_engine() -> None:
    """Stop the engine of this Blender, if there ever was one."""
    if has_run(engine_requests):
        engine_requests.stop_engine()


def _finish(context: Context) -> None:
    """End the check: store its facts and use the engine, or store its error."""
    work, engine_state.STATE.work = engine_state.STATE.work, None
    assert work is not None
    if work.error is None:
        if engine_state.STATE.chosen:
            engine_state.choose(context, engine_state.STATE.chosen)
        engine_state.STATE.facts = work.result
        engine_requests.stop_engine()  # the next request starts the new one
    elif work.error.kind != "Cancelled":
        _store_error(work.error, work.lines)


def _store_error(error: S2agError, lines: Sequence[str] = ()) -> None:
    """Show ``error`` in the preferences, and save the log with what the check printed."""
    engine_state.STATE.error = error
    for line in lines:
        errors_log.add_line(line)
    errors_log.save(error)


def _on_timer() -> float | None:
    """Poll the check; return the seconds until the next poll, None when it is over, as Blender's timers want it."""
    return 0.1 if tick() else None


class _Idle(Button):
    """Base of operators that wait until no check is under way."""

    bl_options = {"REGISTER"}

    @classmethod
    def why_not(cls, context: Context) -> str:
        return translate("The engine is being tried") if engine_state.STATE.work is not None else ""


def _check(operator: bpy.types.Operator, context: Context, path: str = "") -> OperatorResult:
    """Check an engine: by a timer that does not block; in background mode wait for the end."""
    try:
        if bpy.app.background:
            check(context, path)
            operator.report({"INFO"}, translate("The engine works"))
        else:
            begin(context, path)
            bpy.app.timers.register(_on_timer, first_interval=0.1)
    except S2agError as error:
        if engine_state.STATE.error is not error:
            _store_error(error)
        operator.report({"ERROR"}, translate_error(error))
        return {"CANCELLED"}
    return {"FINISHED"}


class S2AG_OT_engine_choose(_Idle, bpy.types.Operator):
    """Use a full engine in a Python of your own: it gestures a clip first, and is kept if it can"""

    bl_label = "Choose Engine"

    filepath: bpy.props.StringProperty(
        name="File Path",
        description="A Python with the package s2ag[full], or the folder of its environment",
        subtype="FILE_PATH",
    )

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        if not self.filepath:
            self.filepath = str(Path.home()) + "/"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> OperatorResult:
        path = bpy.path.abspath(self.filepath)
        if not path:
            self.report({"ERROR"}, translate("Choose a folder or a Python"))
            return {"CANCELLED"}
        return _check(self, context, path)


class S2AG_OT_engine_check(_Idle, bpy.types.Operator):
    """Let the engine in use gesture a clip, and show what it has"""

    bl_label = "Check Engine"

    def execute(self, context: Context) -> OperatorResult:
        return _check(self, context)


class S2AG_OT_engine_cancel(OperatorMixin, bpy.types.Operator):
    """Stop trying the engine; the one in use stays"""

    bl_label = "Cancel"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return engine_state.STATE.work is not None

    def execute(self, context: Context) -> OperatorResult:
        if engine_state.STATE.work is not None:
            engine_state.STATE.work.cancel()
        return {"FINISHED"}


class S2AG_OT_engine_leave(_Idle, bpy.types.Operator):
    """Use the engine that comes with the extension again; the chosen one stays where it is"""

    bl_label = "Use the Extension's Own"

    @classmethod
    def why_not(cls, context: Context) -> str:
        own = not engine_state.chosen_path(context)
        return translate("The engine that comes with the extension is used") if own else super().why_not(context)

    def work(self, context: Context) -> None:
        engine_requests.stop_engine()
        engine_state.choose(context, "")


class S2AG_OT_open_log(Button, bpy.types.Operator):
    """Show the log of what failed, in a text editor"""

    bl_label = "Open Log"
    bl_options = {"REGISTER"}

    @classmethod
    def why_not(cls, context: Context) -> str:
        return translate("Nothing has failed in this session") if errors_log.latest() is None else ""

    def work(self, context: Context) -> str:
        path = errors_log.latest()
        assert path is not None
        is_shown = _show(context, errors_log.text_block(path))
        return translate("{path} is open", path=path) if is_shown else translate("{path} is in the texts", path=path)


class S2AG_OT_open_help(OperatorMixin, bpy.types.Operator):
    """Show the README that comes with the extension, in a text editor: first steps, and what each part does"""

    bl_label = "Open Help"

    def execute(self, context: Context) -> OperatorResult:
        block = errors_log.text_block(_README, "S2AG README.md")
        block.cursor_set(0)
        if not _show(context, block):
            self.report({"INFO"}, translate("{path} is in the texts", path=block.name))
        return {"FINISHED"}


def _show(context: Context, block: bpy.types.Text) -> bool:
    """Show a text block in an open text editor, else in a new window; return False if there are no windows."""
    if bpy.app.background:
        return False
    editor: Any = next((area for area in context.screen.areas if area.type == "TEXT_EDITOR"), None)
    if editor is None:
        bpy.ops.wm.window_new()
        editor = context.window_manager.windows[-1].screen.areas[0]
        editor.type = "TEXT_EDITOR"
    editor.spaces.active.text, editor.spaces.active.show_word_wrap = block, True
    return True
