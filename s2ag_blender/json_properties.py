"""Reads JSON from custom properties of a .blend, which anybody may have written: invalid data reads as empty."""

from collections.abc import Mapping
from types import UnionType
from typing import Any

import bpy

from ..core import json_text

LARGEST = 16_000_000
"""Most characters of one property; a pose and all settings take about ten thousand."""


def read(owner: bpy.types.bpy_struct, name: str, kind: type = dict) -> Any:
    """Return the dict or list (``kind``) that the custom property ``name`` holds, an empty one if it holds no such JSON."""
    try:
        value = json_text.parse(text(owner, name), LARGEST)
    except json_text.NotJson:
        return kind()
    return value if isinstance(value, kind) else kind()


def text(owner: bpy.types.bpy_struct, name: str) -> str:
    """Return the text that the custom property ``name`` holds, "" if it holds anything else."""
    value = owner.get(name)
    return value if isinstance(value, str) else ""


def has_types(value: Mapping[str, Any], kinds: Mapping[str, type | tuple[type, ...] | UnionType]) -> bool:
    """Return whether each entry of ``value`` that is named in ``kinds`` has the type given there; a bool is no number."""
    return all(isinstance(value[name], kind) and type(value[name]) is not bool for name, kind in kinds.items() if name in value)
