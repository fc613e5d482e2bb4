"""How ready a character is: what each part of the body maps to, worked out once for a rig and then only looked up."""

from dataclasses import dataclass

import bpy

from ..core.errors import S2agError
from ..core.skeleton import EDGE_NAMES
from ..rigs.family import families
from ..rigs.plain import ARMS, Finding
from . import handpicked, rig
from .translations import told


@dataclass(frozen=True)
class Row:
    """One part: its name for people, its bones, whether it is found, and what stands in the way."""

    part: str
    bones: tuple[str, ...]
    found: bool
    note: str = ""


@dataclass(frozen=True)
class Readiness:
    """Rows in the body's order, the family of the rig, warnings, and the sentence that tells why it cannot gesture at all."""

    rows: tuple[Row, ...] = ()
    family: str = ""
    warnings: tuple[str, ...] = ()
    problem: str = ""

    @property
    def ready(self) -> bool:
        """Whether the character can gesture."""
        return not self.problem

    @property
    def found(self) -> int:
        """How many parts have bones."""
        return sum(row.found for row in self.rows)


_known: dict[tuple, Readiness] = {}
_wanted: set[str] = set()


def of(armature: bpy.types.Object) -> Readiness:
    """The readiness of a character; slow for a large rig the first time."""
    key = _key(armature)
    if key not in _known:
        forget(armature)
        _known[key] = _look(armature)
    return _known[key]


def known(armature: bpy.types.Object) -> Readiness | None:
    """The readiness if it has been worked out; else None, and it is worked out as soon as Blender is idle. For drawing.

    Without a window nothing is ever idle, so it is worked out now.
    """
    found = _known.get(_key(armature))
    if found is not None or bpy.app.background:
        return found or of(armature)
    later(armature)
    return None


def later(armature: bpy.types.Object) -> None:
    """Work out the readiness as soon as Blender is idle."""
    _wanted.add(armature.name)
    if not bpy.app.timers.is_registered(catch_up):
        bpy.app.timers.register(catch_up, first_interval=0.0)


def stop() -> None:
    """Forget everything and work out nothing more; a timer that outlives the extension would hang Blender's end."""
    forget()
    if bpy.app.timers.is_registered(catch_up):
        bpy.app.timers.unregister(catch_up)


def forget(armature: bpy.types.Object | None = None) -> None:
    """Look at a character (at all of them, if None) afresh the next time."""
    for key in [key for key in _known if armature is None or key[0] == armature.name]:
        del _known[key]
    _wanted.clear()


def label(part: str) -> str:
    """A part's name as a heading: "Left Upper Arm"."""
    return part.replace("_", " ").title()


def _key(armature) -> tuple:
    data = armature.animation_data
    tweaked = data is not None and data.use_tweak_mode
    return armature.name, len(armature.data.bones), len(armature.s2ag.bone_map), armature.mode == "EDIT", tweaked


def _look(armature) -> Readiness:
    try:
        rig.require_armature(armature)
    except S2agError as error:
        return Readiness(problem=str(error))
    try:
        mapping, refusal = rig.survey(armature, handpicked.chosen(armature.s2ag))
    except S2agError as error:
        return Readiness(problem=str(error))
    found = {one.part: one for one in mapping.findings}
    rows = [_row(part, mapping.chains.get(part, ()), found.get(part)) for part in EDGE_NAMES]
    names = {family.key: family.name for family in families()}
    family = names.get(mapping.family, mapping.family)
    return Readiness(tuple(rows), family, mapping.warnings, "" if refusal is None else str(refusal))


def _row(part: str, bones: tuple[str, ...], found: Finding | None) -> Row:
    if bones:
        return Row(part, bones, True)
    known = found.note if found is not None else ""
    return Row(part, (), False, known or (told("needed") if part in ARMS else told("stays as it is")))


def catch_up() -> None:
    """Work out what is wanted, and draw."""
    names = list(_wanted)
    _wanted.clear()
    for name in names:
        armature = bpy.data.objects.get(name)
        if armature is not None and armature.type == "ARMATURE" and _key(armature) not in _known:
            of(armature)
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
