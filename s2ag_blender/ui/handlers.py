"""What happens by itself when files come and go."""

import bpy
from bpy.app.handlers import persistent

from ..rig import readiness
from ..takes import drafts, preview, session


@persistent
def _before_load(*_) -> None:
    preview.stop()
    session.clear()
    readiness.stop()


@persistent
def _before_save(*_) -> None:
    drafts.drop_all()


@persistent
def _after_undo(*_) -> None:
    readiness.forget()
    if not preview.is_on():
        preview.stop()  # a step back may lead to where a draft was played


@persistent
def _after_update(_scene, depsgraph=None, *_) -> None:
    # With every change of anything: nothing but a note may be made here.
    if depsgraph.id_type_updated("ARMATURE"):
        readiness.changed(rigs=True)
    elif depsgraph.id_type_updated("OBJECT"):
        readiness.changed()


_HANDLERS = (
    (bpy.app.handlers.load_pre, _before_load),
    (bpy.app.handlers.save_pre, _before_save),
    (bpy.app.handlers.undo_post, _after_undo),
    (bpy.app.handlers.redo_post, _after_undo),
    (bpy.app.handlers.depsgraph_update_post, _after_update),
)


def register() -> None:
    """Listen."""
    for events, handler in _HANDLERS:
        events.append(handler)


def unregister() -> None:
    """Listen no more, and end what is under way."""
    for events, handler in reversed(_HANDLERS):
        events.remove(handler)
    preview.stop()
    if bpy.app.timers.is_registered(preview.tick):
        bpy.app.timers.unregister(preview.tick)
    session.clear()
    readiness.stop()
