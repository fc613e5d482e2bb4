"""Live preview: updates a draft of the gestures while sliders move. Off by default; drafts are never saved.

One draft per character is computed at a time. It is shown when it is ready, whatever has changed since, so that the
character moves while a slider is dragged; the next draft is requested before this one is keyed, so that the engine works while
Blender keys and draws. A draft is one action whose curves are replaced, outside undo; the final take replaces it."""

from collections.abc import Callable
from typing import Any

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context, current_context, is_armature
from . import drafts, engine_requests, generate, session
from .operator_base import character, redraw

TICK = 0.03
"""Seconds between polls while a draft is being computed."""

_pending: set[int] = set()
"""``session_uid`` of the characters that have changed."""
_jobs: dict[int, tuple[Any, generate.Plan]] = {}
"""``{session_uid: (job, plan)}`` of the drafts being computed."""


def is_on(context: Context | None = None) -> bool:
    """Return whether the live preview is on."""
    return (context or current_context()).window_manager.s2ag.live


def request_draft(armature: ArmatureObject) -> None:
    """Request a new draft, because a setting of this character changed."""
    if not is_on() or armature.session_uid in session.RUNS:
        return
    _pending.add(armature.session_uid)
    # Background mode runs no timers, and a leftover one would hang Blender at exit; scripts call tick themselves.
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=TICK)


def preview_switched(context: Context) -> None:
    """Start or stop the preview after its switch was changed."""
    armature = character(context)
    if not is_on(context):
        stop()
    elif armature is not None:
        request_draft(armature)


def stop() -> None:
    """Cancel all requests and remove all drafts; characters play their former actions again."""
    for uid in list(_jobs):
        _abandon(uid)
    _pending.clear()
    drafts.drop_all()


def tick() -> float | None:
    """Key finished drafts and request pending ones; return seconds until the next call, or None if nothing is left."""
    for uid in list(_jobs):
        _run_guarded(uid, _receive)
    for uid in _pending - _jobs.keys():
        _pending.discard(uid)
        _run_guarded(uid, _request)
    return TICK if _pending or _jobs else None


def _request(uid: int) -> None:
    armature = next((item for item in bpy.data.objects if item.session_uid == uid and is_armature(item)), None)
    if armature is not None and uid not in session.RUNS:
        planned = generate.plan(current_context(), armature, draft=True)
        _jobs[uid] = engine_requests.start(current_context(), planned.params), planned


def _receive(uid: int) -> None:
    job, planned = _jobs[uid]
    result = engine_requests.poll(job, lambda stage, value: None)
    if result is None:
        return
    del _jobs[uid]
    if uid in _pending:
        _pending.discard(uid)
        _request(uid)
    if uid not in session.RUNS:
        generate.finish(planned, result)
        session.ERRORS.pop(uid, None)
        redraw(current_context())


def _run_guarded(uid: int, work: Callable[[int], None]) -> None:
    """Call ``work(uid)``; an error ends the draft and is shown in the panel."""
    try:
        work(uid)
    except S2agError as error:
        _abandon(uid)
        if error.kind != "Cancelled":
            session.fail(uid, error)
            redraw(current_context())


def _abandon(uid: int) -> None:
    job, _ = _jobs.pop(uid, (None, None))
    engine_requests.cancel(job)
