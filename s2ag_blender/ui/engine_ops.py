"""Operators of the engine's set-up: modal in a window, blocking without one. They call what engine_setup does."""

import time

import bpy

from ...core.errors import S2agError
from ..engine import errors_log, known, run, setup
from ..engine.client import find_interpreter
from ..engine.known import STATE
from ..takes import gesture
from ..takes.running import redraw
from ..translations import told, told_error


def set_up(context, plan: setup.Plan | None = None, progress=None) -> dict:
    """Make the engine's environment and wait: the headless way. Returns the facts of the engine.

    Raises :class:`engine_setup.SetupFailed`, without doing anything where the registry would be used offline.
    """
    run = begin(context, plan)
    try:
        return run.wait(progress)
    finally:
        STATE.work = None
        _finished(run)


def begin(context, plan: setup.Plan | None = None) -> run.Setup:
    """Start making the environment and return at once; :func:`tick` follows it."""
    plan = plan or known.planned(context)
    require_online(plan)
    STATE.error = None
    STATE.work = run.Setup(plan)
    return STATE.work


def require_online(plan: setup.Plan) -> None:
    """Raise :class:`engine_setup.SetupFailed` if ``plan`` needs the network and Blender's preferences forbid it."""
    if plan.wheels is None and not bpy.app.online_access:
        raise setup.SetupFailed(
            "Online access is off in Blender's preferences.",
            "Allow it under System, Network, or choose a folder of wheels.",
        )


def tick() -> bool:
    """Follow the work under way; True while there is more to do."""
    work = STATE.work
    if work is None:
        return False
    more = not work.poll()
    if not more:
        STATE.work = None
        _finished(work)
    _redraw()
    return more


def stop() -> None:
    """End what is under way; nothing half-made stays."""
    if STATE.work is not None:
        STATE.work.cancel()
        tick()


def _finished(work) -> None:
    STATE.error = work.error if work.error and work.error.kind != "Cancelled" else None
    if work.error is None:
        STATE.facts = work.result
        gesture.stop_engine()  # the next request starts the new one
    elif STATE.error is not None:
        errors_log.save(work.error)


def _redraw() -> None:
    redraw(bpy.context)
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PREFERENCES":
                area.tag_redraw()


def _carry_on() -> float | None:
    """Follow the work when the window of its operator was closed."""
    return 0.2 if tick() else None


class _EngineWork:
    """A modal operator that follows :data:`STATE`'s work; Esc cancels it, a closed window does not."""

    def modal(self, context, event):
        if event.type == "ESC" and STATE.work is not None:
            STATE.work.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        work = STATE.work
        if work is not None and tick():
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self._timer)
        return self._told(work or self._work)

    def cancel(self, context):
        context.window_manager.event_timer_remove(self._timer)
        if STATE.work is not None:
            bpy.app.timers.register(_carry_on, first_interval=0.2)

    def _follow(self, context):
        self._work = STATE.work
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _told(self, work):
        if work.error is None:
            self.report({"INFO"}, told("The engine works"))
            return {"FINISHED"}
        self.report({"INFO" if work.error.kind == "Cancelled" else "ERROR"}, told_error(work.error))
        return {"CANCELLED"}

    def _refuse(self, error: S2agError):
        STATE.error = error
        errors_log.save(error)
        _redraw()
        self.report({"ERROR"}, told_error(error))
        return {"CANCELLED"}


def _idle(cls) -> bool:
    if STATE.work is not None:
        cls.poll_message_set(told("The engine is being worked on"))
        return False
    return True


class S2AG_OT_engine_setup(_EngineWork, bpy.types.Operator):
    """Make the engine's Python environment in the extension's folder with the command shown; a former one goes once it works"""

    bl_idname = "s2ag.engine_setup"
    bl_label = "Set Up Engine"

    recognise: bpy.props.BoolProperty(
        name="Also Recognise Speech",
        description="Install the speech recogniser, too, now and whenever the engine is repaired",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return _idle(cls)

    def execute(self, context):
        try:
            set_up(context, self._plan(context))
        except S2agError as error:
            return self._refuse(error)
        self.report({"INFO"}, told("The engine works"))
        return {"FINISHED"}

    def invoke(self, context, event):
        try:
            begin(context, self._plan(context))
        except S2agError as error:
            return self._refuse(error)
        return self._follow(context)

    def _plan(self, context) -> setup.Plan:
        chosen = known.settings(context)
        if self.recognise and chosen is not None:
            chosen.recognise = True
        return known.planned(context, recognise=self.recognise)


class S2AG_OT_engine_check(_EngineWork, bpy.types.Operator):
    """Try the engine's Python and show what it has"""

    bl_idname = "s2ag.engine_check"
    bl_label = "Check Engine"

    @classmethod
    def poll(cls, context):
        return _idle(cls)

    def execute(self, context):
        try:
            STATE.facts = check(context)
        except S2agError as error:
            return self._refuse(error)
        self.report({"INFO"}, told("The engine works"))
        return {"FINISHED"}

    def invoke(self, context, event):
        known.look(context)
        try:
            STATE.work = run.Check(engine_python(context))
        except S2agError as error:
            return self._refuse(error)
        return self._follow(context)


class S2AG_OT_engine_cancel(bpy.types.Operator):
    """Stop at once; nothing half-made is left behind"""

    bl_idname = "s2ag.engine_cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return STATE.work is not None

    def execute(self, context):
        STATE.work.cancel()
        return {"FINISHED"}


class S2AG_OT_engine_remove(bpy.types.Operator):
    """Delete the environment that the set-up made"""

    bl_idname = "s2ag.engine_remove"
    bl_label = "Remove Engine"

    @classmethod
    def poll(cls, context):
        if known.engine() is None:
            cls.poll_message_set(told("The set-up has made no environment"))
            return False
        return _idle(cls)

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context):
        gesture.stop_engine()
        try:
            setup.remove(known.folder())
        except S2agError as error:
            self.report({"ERROR"}, told_error(error))
            return {"CANCELLED"}
        known.look(context)
        self.report({"INFO"}, told("The engine is removed"))
        return {"FINISHED"}


class S2AG_OT_copy_command(bpy.types.Operator):
    """Copy the commands that set the engine up, to run them in a terminal"""

    bl_idname = "s2ag.copy_command"
    bl_label = "Copy Command"

    def execute(self, context):
        try:
            context.window_manager.clipboard = known.planned(context, check=False).text
        except S2agError as error:
            self.report({"ERROR"}, told_error(error))
            return {"CANCELLED"}
        self.report({"INFO"}, told("Copied"))
        return {"FINISHED"}


class S2AG_OT_open_log(bpy.types.Operator):
    """Show the log of what failed, in a text editor"""

    bl_idname = "s2ag.open_log"
    bl_label = "Open Log"

    @classmethod
    def poll(cls, context):
        if errors_log.latest() is None:
            cls.poll_message_set(told("Nothing has failed in this session"))
            return False
        return True

    def execute(self, context):
        path = errors_log.latest()
        try:
            block = errors_log.text_block(path)
        except OSError as error:
            self.report({"ERROR"}, told("{path} cannot be read: {reason}", path=path, reason=error.strerror))
            return {"CANCELLED"}
        shown = _show(context, block)
        self.report({"INFO"}, told("{path} is open", path=path) if shown else told("{path} is in the texts", path=path))
        return {"FINISHED"}


CLASSES = (
    S2AG_OT_engine_setup,
    S2AG_OT_engine_check,
    S2AG_OT_engine_cancel,
    S2AG_OT_engine_remove,
    S2AG_OT_copy_command,
    S2AG_OT_open_log,
)


def engine_python(context) -> str:
    """The engine's Python, or :class:`WorkerFailed`."""
    return find_interpreter(known.interpreter(context))


def check(context) -> dict:
    """Try the engine's Python and wait; returns its facts or raises the :class:`S2agError` that says why it cannot work."""
    work = run.Check(engine_python(context))
    while not work.poll():
        time.sleep(run.PAUSE)
    if work.error:
        raise work.error
    return work.result


def _show(context, block) -> bool:
    """Show a text block in a text editor that is open, else in a new window; False where there are no windows."""
    if bpy.app.background:
        return False
    editor = next((area for area in context.screen.areas if area.type == "TEXT_EDITOR"), None)
    if editor is None:
        bpy.ops.wm.window_new()
        editor = context.window_manager.windows[-1].screen.areas[0]
        editor.type = "TEXT_EDITOR"
    editor.spaces.active.text = block
    return True
