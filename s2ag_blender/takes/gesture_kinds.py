"""What kinds of gesture and styles show, as menus tell it: a sentence for each kind, and small pictures of both."""

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
_STYLES = Path(__file__).parents[2] / "core" / "assets" / "styles"
"""Pictures of the shipped styles; docs/style_pictures.py makes them."""


@functools.cache  # Blender keeps no reference to the texts of a menu
def pictured(kinds: tuple[tuple[str, str, str], ...]) -> list[tuple]:
    """Return items of kinds with their pictures."""
    return [(name, label, told, _icon(name), number) for number, (name, label, told) in enumerate(kinds)]


def _icon(name: str) -> int:
    """Return the number of the icon that shows a kind, 0 for none; without a window nobody sees it, and it is not drawn."""
    shown = vocabulary.load_vocabulary().gestures
    if bpy.app.background or name not in shown:
        return 0
    if name in _pictures():
        return _pictures()[name].icon_id
    picture = _pictures().new(name)
    picture.image_size = picture.icon_size = gesture_picture.SIZE, gesture_picture.SIZE
    pixels = gesture_picture.draw(shown[name]).ravel().tolist()
    picture.image_pixels_float = picture.icon_pixels_float = pixels
    return picture.icon_id


def style_icon(name: str) -> int:
    """Return the number of the icon that shows where the hands of a style go; 0 for none."""
    path = _STYLES / f"{name}.png"
    if bpy.app.background or not path.is_file():
        return 0
    return (_pictures().get(str(path)) or _pictures().load(str(path), str(path), "IMAGE")).icon_id


@functools.cache
def _pictures() -> Any:
    return bpy.utils.previews.new()


def drop_pictures(*others: Any) -> None:
    """Drop the pictures, which Blender would miss at its end, and what ``others`` hold of them, caches."""
    if _pictures.cache_info().currsize:
        bpy.utils.previews.remove(_pictures())
    for cached in (_pictures, pictured, *others):
        cached.cache_clear()
