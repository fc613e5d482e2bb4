"""Panels, operators, menus and properties."""

from ..lazy_modules import lazily

lazily("takes", "render", "keys", "characters", "rig", "engine")
