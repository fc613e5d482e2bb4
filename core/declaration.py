"""How a setting is declared: a dataclass field whose metadata say where it appears and which values it may have.

:mod:`settings` holds the declarations; the command line, the worker, manifests, provenance and Blender's panel read them by
:func:`table`. Needs neither numpy nor Blender.
"""

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields, make_dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, Literal

from .errors import UsageError

NUMBERS = ("number", "side")
"""Kinds that are numbers with a fraction."""
KINDS: dict[str, type | tuple[type, ...]] = {
    "number": (int, float), "whole": int, "flag": bool, "text": str, "path": str, "style": (str, dict),
    "side": (int, float), "affects": dict, "document": dict, "points": list, "list": list,
}  # fmt: skip
"""Kind of a setting -> its types in JSON. A ``side`` is a number that may be written left or right, ``affects`` are numbers by
name, a ``document`` is a JSON file for people and its content for programs, ``points`` are lists of numbers.
"""
SAME: Any = object()
"""Stands for what is not declared, where None is a value."""
_KIND_OF = {float: "number", int: "whole", bool: "flag", str: "text", dict: "affects"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """All that is known of a setting. Empty texts mean that it does not appear in the place they are for.

    ``default`` is what a script gets that does not mention it, ``usual`` what commands, manifests and the panel begin with.
    """

    name: str
    default: Any
    kind: str

    low: float | None = None
    high: float | None = None
    usual: Any = SAME
    by_character: Callable[[str | None], float] | None = None
    """What a command uses where the option is left out, by the name of the character (None: no character)."""
    wrong: str = ""
    """Error sentence for a value out of range, with ``{}`` for the value; by default made of the label."""
    remedy: str = ""
    alternatives: str = ""
    """At most one of the settings with the same text here may be given."""
    conflict: tuple[str, str] = ("", "")
    """Error sentence and remedy for two of the ``alternatives``."""
    control: bool = False
    """Steers the style, -1..1; only for weights that have learned its direction."""
    curve: bool = False
    """Can change over time."""
    parts: type | None = None
    """The class whose settings are the numbers of ``affects``."""

    help: str = ""
    metavar: str = ""
    after: str = ""
    """The option after which this one is listed, where that is not the order of declaration."""
    choices: tuple[str, ...] = ()

    parameter: bool = True
    """Whether the worker takes it."""
    column: bool = False
    empty: Any = SAME
    """What an empty cell of a manifest stands for, where that is not ``usual``."""
    unit: str = ""

    recording: bool = False
    """Part of what is heard: requests that differ in it do not share a heard recording."""
    heard: bool = False
    """Whether it is set (not its value) decides what is heard of a recording."""
    words: bool = False
    """Says where the words come from."""
    cell: tuple[str, ...] = ()
    """``own``: a cell of a sample brings its value and takes no other; ``sheet``: all cells of a sample have the same value."""
    meta: Literal["", "always", "set"] = ""
    """Whether it is written into a motion's provenance: always, or where it is not the default."""
    restored: tuple[str, ...] = ()
    """What is made anew with its value from provenance: ``arms``, ``face``."""
    beside_arms: bool = False
    """Makes a part of the motion that does not depend on arms, trunk and hands being made anew."""
    partner: bool = False
    """Set by whom a character talks with."""

    label: str = ""
    tip: str = ""
    rna: str = ""
    """Its identifier in Blender, where that is not the name."""
    group: str = ""
    """The group of rows in the panel."""
    short: str = ""
    """The label beside a group's title."""
    soft_high: float | None = None
    panel_high: float | None = None
    shown: float | None = None
    """Blender's default, where a switch of its own turns the setting on."""
    switch: str = ""
    """The boolean property without which it is not sent to the engine."""
    hidden_by: str = ""
    """The boolean property that makes it meaningless."""
    longest: int = 0
    """Letters of a text in Blender, 0 for any number."""
    previewed: bool = True
    """Whether the live preview follows it."""
    preset: bool = False

    @property
    def usually(self) -> Any:
        """What commands, manifests and the panel begin with."""
        return self.default if self.usual is SAME else self.usual

    @property
    def identifier(self) -> str:
        """Its name in Blender."""
        return self.rna or self.name

    @property
    def flag(self) -> str:
        """Its name on the command line."""
        return "--" + self.name.replace("_", "-")

    def check(self, value: Any) -> None:
        """Raise :class:`UsageError` for a value out of range. Controls are checked by :func:`styles.controls`."""
        if self.control or (self.low is None and self.high is None):
            return
        low, high = (-float("inf") if self.low is None else self.low), (float("inf") if self.high is None else self.high)
        if not low <= value <= high:
            shown = f"{value:g}" if isinstance(value, float) else f"{value}"
            sentence = self.wrong or f"{self.label} {{}} is out of range."
            raise UsageError(sentence.format(shown), self.remedy or f"Give a number from {low:g} to {high:g}.")


def setting(default: Any = None, **about: Any) -> Any:
    """Return a dataclass field that is a setting; ``about`` are attributes of :class:`Setting`, a default ``dict`` is empty."""
    metadata = MappingProxyType({"about": about})
    return field(default_factory=default, metadata=metadata) if default is dict else field(default=default, metadata=metadata)


@cache
def table(cls: type) -> dict[str, Setting]:
    """Return the settings that a dataclass declares or inherits, by name, in order of declaration."""
    found = {}
    for one in fields(cls):
        if "about" in one.metadata:
            about = {"kind": _KIND_OF.get(one.type, ""), **one.metadata["about"]}
            default = one.default if one.default_factory is MISSING else one.default_factory()
            found[one.name] = Setting(name=one.name, default=default, **about)
    return found


def columns(*classes: type) -> dict[str, Setting]:
    """Return the settings of classes that are columns of a manifest, by name."""
    return {name: one for cls in classes for name, one in table(cls).items() if one.column}


def row_of(*classes: type) -> type:
    """Return a dataclass whose fields are the :func:`columns` of classes, with what an empty cell stands for as defaults.

    Documents are named by their paths.
    """
    rows = []
    for name, one in columns(*classes).items():
        start = one.usually if one.empty is SAME else one.empty
        start = None if one.kind == "document" else start
        rows.append((name, Any, field(default_factory=dict) if isinstance(start, dict) else field(default=start)))
    return make_dataclass("Row", rows, frozen=True, kw_only=True)


def sliders(cls: type) -> list[Setting]:
    """Return the settings of a class that Blender shows, those with parts replaced by their parts."""
    listed = [part for one in table(cls).values() for part in (sliders(one.parts) if one.parts else [one])]
    return [one for one in listed if one.label]


def options(*classes: type) -> list[Setting]:
    """Return the settings of classes that are options of a command, in the order of its help."""
    listed = [one for cls in classes for one in table(cls).values() if one.help]
    for one in [one for one in listed if one.after]:
        listed.remove(one)
        listed.insert(1 + next(row for row, other in enumerate(listed) if other.name == one.after), one)
    return listed
