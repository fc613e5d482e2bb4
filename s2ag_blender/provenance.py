"""Stores how a motion was made (settings, seed, take, edits) on its action, as JSON text."""

import json
from typing import Any

import bpy

from ..core.version import VERSION
from . import json_properties

PROPERTY = "s2ag"
"""Name of the action's custom property."""

_KINDS = {"place": dict, "settings": dict, "seed": int, "take": int, "style": (str, dict), "near": (list, type(None))}
_KINDS |= {"pose": (list, type(None)), "keyed_pose": (dict, type(None)), "checkpoint": str, "edits": list, "touched": list}
_KINDS |= {"start": (int, float), "way": (list, type(None)), "chance": int, "follows": (dict, type(None))}
_PLACE = {"result": str, "first": int, "last": int, "influence": (int, float), "blend_in": int, "blend_out": int}


def stamp(action: bpy.types.Action, meta: dict[str, Any]) -> None:
    """Store ``meta`` and this package's version on an action."""
    action[PROPERTY] = json.dumps({**meta, "version": VERSION}, sort_keys=True)


def linked(action: bpy.types.Action, name: str) -> bpy.types.Action | None:
    """Return the action that the property ``name`` of an action points to; None if it holds anything else."""
    other = action.get(name)
    return other if isinstance(other, bpy.types.Action) else None


def require(action: bpy.types.Action | None) -> dict[str, Any]:
    """Return what :func:`stamp` stored on an action that this package is known to have made."""
    meta = read(action)
    assert meta is not None
    return meta


def read(action: bpy.types.Action | None) -> dict[str, Any] | None:
    """Return what :func:`stamp` stored on an action; None if there is none or its values have wrong types."""
    meta = json_properties.read(action, PROPERTY) if action is not None else None
    return (
        meta
        if meta and json_properties.has_types(meta, _KINDS) and json_properties.has_types(meta.get("place", {}), _PLACE)
        else None
    )
