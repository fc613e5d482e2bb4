"""Builds a character's properties in Blender from two tables, and draws sliders.

The tables are that of the engine's settings (:mod:`core.settings`), and ``properties.json`` of those that Blender alone has."""

import json
import math
from pathlib import Path
from typing import Any

import bpy

from ...core.declaration import Setting
from ...core.settings import SWITCHES, Models, Settings, sliders
from .. import compat
from ..takes import menu_items

EDITABLE: Any = {"LIBRARY_OVERRIDABLE"}
"""Option of properties that can be changed on library overrides."""
SETTINGS = {one.identifier: one for one in sliders(Settings) + sliders(Models)}
"""Identifier in Blender -> setting, in the order of the panels."""
PRESETS = tuple(identifier for identifier, one in SETTINGS.items() if one.preset)
"""Properties that a preset sets."""
_CONTROL_STEP = 5
"""Hundredths by which the arrows of a control's slider change it."""
_TABLE = Path(__file__).with_name("properties.json")


def update_preview(settings: Any, context: bpy.types.Context) -> None:
    """Update the live preview after a change of a setting."""
    from ..takes import preview

    preview.request_draft(settings.id_data)


def _declared(about: dict[str, Any]) -> Any:
    """Return the deferred Blender property of an entry of ``properties.json``; the numbers of an angle are degrees there."""
    about = {
        name: set(value) if name in ("options", "default") and isinstance(value, list) else value
        for name, value in ({"options": []} | about).items()  # without options they could be keyed, and what cannot vary is not
    }
    kind, is_previewed = getattr(bpy.props, f"{about.pop('type')}Property"), about.pop("previewed", False)
    if about.get("subtype") == "ANGLE":
        about |= {name: math.radians(about[name]) for name in ("default", "min", "max")}
    if about.get("subtype") == "FILE_PATH":
        about["options"] = compat.RELATIVE
    if "items" in about:
        about["items"] = [tuple(item) for item in about["items"]]
    return kind(**about, override=EDITABLE, **({"update": update_preview} if is_previewed else {}))


def _property(one: Setting) -> Any:
    """Return the deferred Blender property of a setting."""
    about: dict = {"name": one.label, "description": one.tip, "override": EDITABLE}
    about |= {"update": update_preview} if one.previewed else {}
    about |= {} if one.curve else {"options": set()}  # a key on what cannot vary is refused
    if one.kind == "flag":
        return bpy.props.BoolProperty(default=one.usually, **about)
    if one.kind in ("path", "document"):
        return bpy.props.StringProperty(subtype="FILE_PATH", **{**about, "options": compat.RELATIVE})
    if one.kind == "style":
        search: Any = menu_items.search_styles
        return bpy.props.StringProperty(search=search, search_options={"SUGGESTION"}, **about)
    if one.kind == "text":
        return bpy.props.StringProperty(maxlen=one.longest, **about)
    high = one.high if one.panel_high is None else one.panel_high
    limits = {"min": one.low, "max": high, "soft_max": one.soft_high}
    about |= {name: value for name, value in limits.items() if value is not None}
    about |= {"default": one.usually if one.shown is None else one.shown}
    if one.kind == "whole":
        return bpy.props.IntProperty(**about)
    about |= {"subtype": "FACTOR"} if one.low is not None else {}
    return bpy.props.FloatProperty(precision=2, **({"step": _CONTROL_STEP} if one.control else {}), **about)


class SettingProperties:
    """The properties of both tables, a part of a character's settings."""

    __annotations__ = {
        name: bpy.props.BoolProperty(name=label, description=tip, override=EDITABLE, options=set())
        for name, (label, tip) in SWITCHES.items()
    }
    __annotations__ |= {identifier: _property(one) for identifier, one in SETTINGS.items()}
    __annotations__ |= {name: _declared(about) for name, about in json.loads(_TABLE.read_text("utf-8")).items()}


def draw_group(layout: bpy.types.UILayout, settings: Any, group: str, steered: bool = True, switches: bool = True) -> None:
    """Draw the settings of a group. Controls form one block, greyed unless ``steered``; settings that depend on a switch are
    drawn below it, greyed while it is off; without ``switches`` the caller draws the switch."""
    blocks: dict = {}
    for identifier, one in SETTINGS.items():
        if one.group != group or (one.hidden_by and getattr(settings, one.hidden_by)):
            continue
        block = "steered" if one.control else one.switch
        if block and block not in blocks:
            if one.switch and switches:
                layout.prop(settings, one.switch)
            blocks[block] = layout.column(align=one.control)
            # Greyed but not disabled, so that users can reset the sliders of files from elsewhere.
            blocks[block].active = getattr(settings, one.switch) if one.switch else steered
        about = {"text": one.short} if one.short else {}
        about |= {"slider": True} if one.kind in ("number", "side") else {}
        place = blocks.get(block, layout)
        place.use_property_decorate = one.curve  # a dot beside what can be keyed
        place.prop(settings, identifier, **about)
