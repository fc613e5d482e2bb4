"""Where a motion came from, kept on its action as JSON text."""

import json

import bpy

from ..core.version import VERSION

PROPERTY = "s2ag"
"""Name of the action's custom property."""


def stamp(action: bpy.types.Action, meta: dict) -> None:
    """Store where a motion came from on its action, with this package's version."""
    action[PROPERTY] = json.dumps({**meta, "version": VERSION}, sort_keys=True)


def of(action: bpy.types.Action) -> dict | None:
    """What :func:`stamp` stored, or None if this package did not make the action."""
    text = action.get(PROPERTY)
    return None if text is None else json.loads(text)
