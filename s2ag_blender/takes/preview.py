"""Live preview: while sliders move, a draft of the gestures follows them. Off unless asked for; drafts are never saved.

One draft at a time is on its way; it is shown when it comes, whatever has changed since, so that the character moves while a
slider is still dragged, and the latest change is asked for before it is laid: the engine works on the next draft while
Blender keys and draws this one. The draft is one action whose curves are replaced, outside undo; the take that is made at the
end takes its place.
"""

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context
from . import drafts, generate, gesture, session
from .running import character, redraw

TICK = 0.03
"""Seconds between looks while a draft is on its way, in which changes gather."""

_wanted: set[int] = set()  # numbers in this session of characters that have changed
_working: dict[int, tuple] = {}  # the same -> (job, plan) on their way


def is_on(context: Context | None = None) -> bool:
    """Whether drafts are wanted in this Blender."""
    return (context or bpy.context).window_manager.s2ag.live


def touch(armature: ArmatureObject) -> None:
    """A setting of this character changed."""
    if not is_on() or armature.session_uid in session.RUNS:
        return
    _wanted.add(armature.session_uid)
    # Without a window nothing runs timers, and one that is left over hangs Blender's end: there, scripts call tick themselves.
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=TICK)


def switched(context: Context) -> None:
    """The preview was switched on or off."""
    armature = character(context)
    if not is_on(context):
        stop()
    elif armature is not None:
        touch(armature)


def stop() -> None:
    """Ask for nothing more and remove all drafts; characters play again what they played before."""
    for uid in list(_working):
        _abandon(uid)
    _wanted.clear()
    drafts.drop_all()


def tick() -> float | None:
    """Lay down drafts that have come and ask for those that are wanted; returns when to look again, None if nothing is left."""
    for uid in list(_working):
        _guarded(uid, _receive)
    for uid in _wanted - _working.keys():
        _wanted.discard(uid)
        _guarded(uid, _ask)
    return TICK if _wanted or _working else None


def _ask(uid: int) -> None:
    armature = _find(uid)
    if armature is not None and uid not in session.RUNS:
        planned = generate.plan(bpy.context, armature, draft=True)
        _working[uid] = gesture.start(bpy.context, planned.params), planned


def _receive(uid: int) -> None:
    job, planned = _working[uid]
    result = gesture.poll(job, lambda stage, value: None)
    if result is None:
        return
    del _working[uid]
    if uid in _wanted:
        _wanted.discard(uid)
        _ask(uid)
    if uid not in session.RUNS:
        generate.finish(planned, result)
        session.MESSAGES.pop(uid, None)
        redraw(bpy.context)


def _guarded(uid: int, work) -> None:
    try:
        work(uid)
    except S2agError as error:
        _abandon(uid)
        if error.kind != "Cancelled":
            session.fail(uid, error)
            redraw(bpy.context)


def _abandon(uid: int) -> None:
    job, _ = _working.pop(uid, (None, None))
    gesture.cancel(job)


def _find(uid: int):
    return next((item for item in bpy.data.objects if item.session_uid == uid), None)
