"""Handlers of Blender's events: file load and save, undo and redo, depsgraph updates."""

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..lazy_modules import has_run
from ..rig import readiness
from ..takes import drafts, gesture_kinds, menu_items, preview, session


@persistent
def _before_load(*_: Any) -> None:
    _stop()


@persistent
def _before_save(*_: Any) -> None:
    drafts.drop_all()


@persistent
def _after_undo(*_: Any) -> None:
    if has_run(readiness):
        readiness.clear_cache()
    if has_run(preview) and not preview.is_on():
        preview.stop()  # undo may restore a draft action


@persistent
def _after_update(_scene: bpy.types.Scene, depsgraph: Any = None, *_: Any) -> None:
    # Called on every change of anything, so it must be cheap.
    if not has_run(readiness):
        return
    if depsgraph.id_type_updated("ARMATURE"):
        readiness.note_change(rigs=True)
    elif depsgraph.id_type_updated("OBJECT"):
        readiness.note_change()


def _stop() -> None:
    """Stop preview, runs and timers, as far as there are any."""
    if has_run(preview):
        preview.stop()
        if bpy.app.timers.is_registered(preview.tick):
            bpy.app.timers.unregister(preview.tick)
    if has_run(session):
        session.clear()
    if has_run(readiness):
        readiness.stop()


_HANDLERS: tuple[tuple[list, Any], ...] = (
    (bpy.app.handlers.load_pre, _before_load),
    (bpy.app.handlers.save_pre, _before_save),
    (bpy.app.handlers.undo_post, _after_undo),
    (bpy.app.handlers.redo_post, _after_undo),
    (bpy.app.handlers.depsgraph_update_post, _after_update),
)


def register() -> None:
    """Add the handlers."""
    for events, handler in _HANDLERS:
        events.append(handler)


def unregister() -> None:
    """Remove the handlers, and stop preview, runs and timers."""
    for events, handler in reversed(_HANDLERS):
        events.remove(handler)
    _stop()
    if has_run(gesture_kinds):
        gesture_kinds.drop_pictures(*menu_items.CACHED)
