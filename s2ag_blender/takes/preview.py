"""Live preview: while sliders move, a draft of the gestures follows them. Off unless asked for; drafts are never saved.

A change is answered after a short pause in which no other comes; an answer that is no longer wanted is cancelled. The
draft is one action whose curves are replaced, outside undo; the take that is made at the end takes its place.
"""

import time

import bpy

from ...core.errors import S2agError
from . import drafts, generate, gesture, session
from .running import character, redraw

PAUSE = 0.12
"""Seconds without a change before a draft is asked for."""
TICK = 0.03
"""Seconds between looks while a draft is on its way."""

_wanted: dict[int, float] = {}  # a character's number in this session -> when it was last changed
_working: dict[int, tuple] = {}  # the same -> (job, plan)


def is_on(context=None) -> bool:
    """Whether drafts are wanted in this Blender."""
    return (context or bpy.context).window_manager.s2ag.live


def touch(armature: bpy.types.Object) -> None:
    """A setting of this character changed."""
    if not is_on() or armature.session_uid in session.RUNS:
        return
    uid = armature.session_uid
    _wanted[uid] = time.monotonic()
    _abandon(uid)
    # Without a window nothing runs timers, and one that is left over hangs Blender's end: there, scripts call tick themselves.
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=PAUSE)


def switched(context) -> None:
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
    """Ask for drafts that are due and lay down those that have come; returns when to look again, None if nothing is left."""
    now = time.monotonic()
    for uid, changed in list(_wanted.items()):
        if now - changed >= PAUSE:
            del _wanted[uid]
            _guarded(uid, _ask)
    for uid in list(_working):
        _guarded(uid, _receive)
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
    if uid not in session.RUNS:
        generate.finish(planned, result)
        session.MESSAGES.pop(uid, None)
        redraw(bpy.context)


def _guarded(uid: int, work) -> None:
    try:
        work(uid)
    except S2agError as error:
        _working.pop(uid, None)
        if error.kind != "Cancelled":
            session.fail(uid, error)
            redraw(bpy.context)


def _abandon(uid: int) -> None:
    job, _ = _working.pop(uid, (None, None))
    gesture.cancel(job)


def _find(uid: int):
    return next((item for item in bpy.data.objects if item.session_uid == uid), None)
