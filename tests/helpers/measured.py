"""A layout that measures: how wide Blender draws a text, and how much room Blender's layouts leave for it in the sidebar.

The numbers are Blender's own (interface_layout.cc, interface_widgets.cc) and were held against a window of 5.2: in a sidebar
as it is at first, labels of settings are whole up to 86 pixels, buttons and sentences with an icon up to 208.
"""

from acted import Sheet
from s2ag.s2ag_blender.takes import menu_items

CONTENT = 236
"""Pixels inside a panel where the sidebar is 280 wide, as it is at first."""
_UNIT, _EDGE, _SHARE = 20, 8, 0.4
_WITH_ICON, _PLAIN = 1.75 * _UNIT, 1.5 * _UNIT


class Text:
    """A text of a leaf and what else it has room for; ``tall`` ones are fields, which take what they get."""

    def __init__(self, text: str, icon: bool = False, more: float = 0.0):
        self.text, self.used = text, _EDGE + _UNIT * icon + more
        self.wide = menu_items.text_width(text) if text else 0.0
        self.natural = _UNIT if not text else self.wide + (_WITH_ICON if icon else _PLAIN) + more

    def cut(self, room: float) -> list[tuple]:
        """What does not fit into ``room`` pixels: the text and how many pixels it lacks."""
        lacks = self.wide - (room - self.used) if self.text else 0
        return [(self.text, round(lacks))] if lacks > 0 else []


class Setting(Text):
    """A setting whose name stands left of its value, and right of that a dot if it is ``decorated``."""

    def __init__(self, name: str, values: list[str], arrow: bool, decorated: bool = False):
        super().__init__("")
        self.dot = _UNIT * decorated
        self.name = Text(name)
        self.values = [Text(value, more=_UNIT * arrow - _EDGE * arrow) for value in values]
        self.natural = 2 * max([self.name.natural, *(value.natural for value in self.values)])

    def cut(self, room: float) -> list[tuple]:
        """What does not fit."""
        room -= self.dot
        return self.name.cut(_SHARE * room) + [one for value in self.values for one in value.cut((1 - _SHARE) * room)]


class Measured(Sheet):
    """A sheet that remembers rows and columns; ``words`` are the translations of the language to measure, empty for English."""

    def __init__(self, words=None, kind="column", factor=None):
        super().__init__()
        self.words, self.kind, self.factor, self.inside = words or {}, kind, factor, []

    def _in(self, kind, factor=None):
        inner = Measured(self.words, kind, factor)
        inner.use_property_split = self.use_property_split
        self.inside.append(inner)
        return inner

    def column(self, heading="", **_):
        return self._in("column")

    def row(self, **_):
        return self._in("row")

    def split(self, factor=0.0, **_):
        return self._in("row", factor)

    def box(self):
        return self._in("column")

    def _told(self, text, translate=True):
        return self.words.get(text, text) if translate else text

    def label(self, text="", icon="NONE", translate=True):
        self.inside.append(Text(self._told(text, translate), icon != "NONE"))

    def progress(self, factor=0.0, text="", **_):
        self.inside.append(Text(text))

    def operator(self, name, text=None, icon="NONE", translate=True, more=0.0, **_):
        options = super().operator(name)
        shown = self._operator(name) if text is None else text
        self.inside.append(Text(self._told(shown, translate), icon != "NONE", more))
        return options

    @staticmethod
    def _operator(name):
        import bpy

        group, _, verb = name.partition(".")
        return getattr(getattr(bpy.ops, group), verb).get_rna_type().name

    def operator_menu_enum(self, name, prop, text=None, icon="NONE", **_):
        return self.operator(name, text=text, icon=icon, more=_UNIT - _EDGE)

    def prop(self, settings, name, text=None, expand=False, slider=False, icon="NONE", toggle=False, **_):
        prop = settings.bl_rna.properties[name]
        label = self._told(prop.name) if text is None else self._told(text)
        items = [self._told(item.name) for item in prop.enum_items] if prop.type == "ENUM" and len(prop.enum_items) else []
        if items and (expand or prop.is_enum_flag):
            row = self._in("column" if prop.is_enum_flag or self.use_property_split and self.kind == "column" else "row")
            row.inside = [Text(item) for item in items]
        elif prop.type == "BOOLEAN" or not self.use_property_split or not label:
            field = prop.type in ("STRING", "POINTER")
            self.inside.append(Text("" if field else label, icon != "NONE", 0 if toggle or prop.type != "BOOLEAN" else _UNIT))
        else:
            self.inside.append(Setting(label, items, bool(items), self.use_property_decorate))

    def template_list(self, *_, **__):
        """Rows of lists hold names of the user's own."""

    def popover(self, *_, **__):
        pass

    @property
    def natural(self):
        """Pixels that it would take."""
        found = [one.natural for one in self.inside] or [0]
        return sum(found) if self.kind == "row" else max(found)

    def cut(self, room: float = CONTENT) -> list[tuple]:
        """All texts that do not fit into ``room`` pixels."""
        if self.kind == "column" or not self.inside:
            return [one for inner in self.inside for one in inner.cut(room)]
        if self.factor and len(self.inside) == 2:
            first, second = self.inside
            return first.cut(self.factor * room) + second.cut((1 - self.factor) * room)
        fixed = sum(one.natural for one in self.inside if one.natural <= _UNIT)
        rest = max(sum(one.natural for one in self.inside if one.natural > _UNIT), 1)
        shares = [one.natural if one.natural <= _UNIT else one.natural / rest * (room - fixed) for one in self.inside]
        return [one for inner, share in zip(self.inside, shares, strict=True) for one in inner.cut(share)]
