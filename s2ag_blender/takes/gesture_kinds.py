"""What the kinds of gesture show, as menus tell it: a sentence each, and a small picture of the pose."""

import functools
import json
from pathlib import Path
from typing import Any

import bpy
import bpy.utils.previews

from ...core.meaning import gesture_picture, vocabulary

GROUPS: dict[str, dict[str, str]] = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
"""Heading of a column of menus -> its kinds of gesture, each with what it shows."""
SHOWN = {name: told for group in GROUPS.values() for name, told in group.items()}
_PICTURES: list[Any] = []


@functools.cache  # Blender keeps no reference to the texts of a menu
def pictured(kinds: tuple[tuple[str, str, str], ...]) -> list[tuple]:
    """Return items of kinds with their pictures."""
    return [(name, label, told, _icon(name), number) for number, (name, label, told) in enumerate(kinds)]


def _icon(name: str) -> int:
    """Return the number of the icon that shows a kind, 0 for none; without a window nobody sees it, and it is not drawn."""
    shown = vocabulary.load_vocabulary().gestures
    if bpy.app.background or name not in shown:
        return 0
    if not _PICTURES:
        _PICTURES.append(bpy.utils.previews.new())
    if name in _PICTURES[0]:
        return _PICTURES[0][name].icon_id
    picture = _PICTURES[0].new(name)
    picture.image_size = picture.icon_size = gesture_picture.SIZE, gesture_picture.SIZE
    pixels = gesture_picture.draw(shown[name]).ravel().tolist()
    picture.image_pixels_float = picture.icon_pixels_float = pixels
    return picture.icon_id


def drop_pictures() -> None:
    """Drop the pictures, which Blender would miss at its end."""
    pictured.cache_clear()
    for pictures in _PICTURES:
        bpy.utils.previews.remove(pictures)
    _PICTURES.clear()
