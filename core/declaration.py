"""Declares settings as dataclass fields whose metadata say where a setting appears and which values it may have.

The declarations are in :mod:`settings`; the command line, the worker, manifests, provenance and Blender's panel read them by
:func:`table`. Needs neither numpy nor Blender."""

from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from types import MappingProxyType
from typing import Any, Literal, cast

from .errors import UsageError

NUMBERS = ("number", "side")
"""Kinds whose values are floating-point numbers."""
KINDS: dict[str, type | tuple[type, ...]] = {
    "number": (int, float), "whole": int, "flag": bool, "text": str, "path": str, "style": (str, dict),
    "side": (int, float), "affects": dict, "document": dict, "points": list, "list": list,
}  # fmt: skip
"""Kind of a setting -> its types in JSON. A ``side`` is a number that may be written left or right; ``affects`` maps names to
numbers; a ``document`` is a JSON file on the command line and its content in requests; ``points`` are lists of numbers."""
SAME: Any = object()
"""Marks an attribute that is not declared, where None is a value."""
_KIND_OF = {float: "number", int: "whole", bool: "flag", str: "text", dict: "affects"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """The declaration of a setting. It does not appear in a place whose text here is empty.

    ``default`` is the value in scripts that do not set it, ``usual`` the default of commands, manifests and the panel."""

    name: str
    default: Any
    kind: str

    low: float | None = None
    high: float | None = None
    """Range of valid values, which is also the slider's."""
    usual: Any = SAME
    by_character: Callable[[str | None], float] | None = None
    """Default of commands as a function of the character's name (None: no character)."""
    wrong: str = ""
    """Error sentence for a value out of range, with ``{}`` for the value; by default built from the label."""
    remedy: str = ""
    alternatives: str = ""
    """Name of a group of which at most one setting may be given."""
    conflict: tuple[str, str] = ("", "")
    """Error sentence and remedy for two of the ``alternatives``."""
    control: bool = False
    """Whether it steers the style, -1..1; only for networks that have learned its direction."""
    curve: bool = False
    """Whether it can change over time."""
    parts: type | None = None
    """Class that declares the numbers of ``affects``."""

    help: str = ""
    metavar: str = ""
    after: str = ""
    """The option after which the help lists this one, if not in the order of declaration."""
    choices: tuple[str, ...] = ()

    parameter: bool = True
    """Whether it is a parameter of the worker."""
    column: bool = False
    """Whether it is a column of manifests."""
    empty: Any = SAME
    """Value of an empty cell of a manifest, if not ``usual``."""
    unit: str = ""

    recording: bool = False
    """Whether the features of a recording depend on its value, so that requests that differ in it do not share them."""
    heard: bool = False
    """Whether the features of a recording depend on its being set at all."""
    timed: bool = False
    """Whether it names seconds or frames of the recording, so that it means nothing for another one."""
    words: bool = False
    """Whether it says where the words come from."""
    cell: tuple[str, ...] = ()
    """``own``: every cell of a sample has its own value, which cannot be changed; ``sheet``: all cells share one value."""
    meta: Literal["", "always", "set"] = ""
    """Whether it is stored in a motion's provenance: always, or if it is not the default."""
    restored: tuple[str, ...] = ()
    """Parts that are regenerated with its value from provenance: ``arms``, ``face``; ``take`` where it tells a take apart from
    others of the same settings."""
    indexed: bool = False
    """Whether the index of a data set has it."""
    beside_arms: bool = False
    """Whether it drives a part of the motion that stays when arms, trunk and hands are regenerated."""
    partner: bool = False
    """Whether it follows from the character's partner in a conversation."""

    label: str = ""
    tip: str = ""
    rna: str = ""
    """Identifier in Blender, if not the name."""
    group: str = ""
    """Group of the panel."""
    short: str = ""
    """Label in the panel, where the group's title makes part of it needless."""
    soft_high: float | None = None
    panel_high: float | None = None
    shown: float | None = None
    """Default in Blender of a setting with a switch."""
    switch: str = ""
    """Boolean property that must be on for it to be sent to the engine."""
    hidden_by: str = ""
    """Boolean property that makes it meaningless."""
    longest: int = 0
    """Maximal number of letters in Blender, 0 for no limit."""
    previewed: bool = True
    """Whether the live preview updates when it changes."""
    preset: bool = False
    """Whether presets store it."""

    @property
    def usually(self) -> Any:
        """Default of commands, manifests and the panel."""
        return self.default if self.usual is SAME else self.usual

    @property
    def identifier(self) -> str:
        """Identifier of its property in Blender."""
        return self.rna or self.name

    @property
    def flag(self) -> str:
        """Option of the command line."""
        return "--" + self.name.replace("_", "-")

    def check(self, value: Any) -> None:
        """Raise :class:`UsageError` for a value out of range. Controls are checked by :func:`styles.controls`."""
        if self.control or value is None or (self.low is None and self.high is None):
            return
        low, high = (-float("inf") if self.low is None else self.low), (float("inf") if self.high is None else self.high)
        if not low <= value <= high:
            shown = f"{value:g}" if isinstance(value, float) else f"{value}"
            sentence = self.wrong or f"{self.label} {{}} is out of range."
            raise UsageError(sentence.format(shown), self.remedy or f"Give a number from {low:g} to {high:g}.")


def setting(default: Any = None, **about: Any) -> Any:
    """Return a dataclass field that declares a setting with attributes ``about`` of :class:`Setting`.

    The default ``dict`` stands for an empty dictionary."""
    metadata = MappingProxyType({"about": about})
    return field(default_factory=default, metadata=metadata) if default is dict else field(default=default, metadata=metadata)


@cache
def table(cls: type) -> dict[str, Setting]:
    """Return the settings that a dataclass declares or inherits, by name, in order of declaration."""
    settings = {}
    for declared in fields(cls):
        if "about" in declared.metadata:
            about = {"kind": _KIND_OF.get(cast(type, declared.type), ""), **declared.metadata["about"]}
            default = declared.default if declared.default_factory is MISSING else declared.default_factory()
            settings[declared.name] = Setting(name=declared.name, default=default, **about)
    return settings


def columns(*classes: type) -> dict[str, Setting]:
    """Return the settings of classes that are columns of a manifest, by name."""
    return {name: one for cls in classes for name, one in table(cls).items() if one.column}


def sliders(cls: type) -> list[Setting]:
    """Return the settings of a class that have a label in Blender; settings with parts are replaced by their parts."""
    listed = [part for one in table(cls).values() for part in (sliders(one.parts) if one.parts else [one])]
    return [one for one in listed if one.label]


def command_options(*classes: type) -> list[Setting]:
    """Return the settings of classes that are options of the command line, in the order of its help."""
    listed = [one for cls in classes for one in table(cls).values() if one.help]
    for one in [one for one in listed if one.after]:
        listed.remove(one)
        listed.insert(1 + next(row for row, other in enumerate(listed) if other.name == one.after), one)
    return listed
