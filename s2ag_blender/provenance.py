"""Where a motion came from, kept on its action as JSON text."""

import json

import bpy

from ..core.version import VERSION
from . import stored

PROPERTY = "s2ag"
"""Name of the action's custom property."""

_KINDS = {"place": dict, "settings": dict, "seed": int, "take": int, "style": (str, dict), "near": (list, type(None))}
_KINDS |= {"pose": (list, type(None)), "keyed_pose": (dict, type(None)), "checkpoint": str, "edits": list, "touched": list}
_KINDS |= {"start": (int, float), "way": (list, type(None)), "follows": (dict, type(None))}
_PLACE = {"result": str, "first": int, "last": int, "influence": (int, float), "blend_in": int, "blend_out": int}


def stamp(action: bpy.types.Action, meta: dict) -> None:
    """Store where a motion came from on its action, with this package's version."""
    action[PROPERTY] = json.dumps({**meta, "version": VERSION}, sort_keys=True)


def of(action: bpy.types.Action) -> dict | None:
    """What :func:`stamp` stored, or None if this package did not make the action, or somebody has changed that since."""
    told = stored.read(action, PROPERTY)
    return told if told and stored.fits(told, _KINDS) and stored.fits(told.get("place", {}), _PLACE) else None
