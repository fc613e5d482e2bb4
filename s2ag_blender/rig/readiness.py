"""How ready a character is: what each part of the body maps to, worked out once for a rig and then only looked up."""

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.errors import S2agError
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs.family import families
from ...rigs.plain import ARMS, Finding, Mapping
from ..translations import told, told_error
from . import handpicked, reading, vrm


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


@dataclass(frozen=True)
class _Look:
    """What a look at a character found, what the rig was made of then, and the number of changes that it has seen."""

    ready: Readiness
    mapping: Mapping | None
    made_of: tuple
    seen: int


PAUSE = 0.3
"""Seconds for which changes gather before a character is looked at again."""

_known: dict[tuple, _Look] = {}
_wanted: set[str] = set()
_changes = 0


def changed(rigs: bool = False) -> None:
    """Something that a readiness may hang on has changed; ``rigs`` if it was an armature itself.

    Blender calls this with every change of an object, so it only notes it. Who asks next compares.
    """
    global _changes
    _changes += 1
    if rigs and _known and not bpy.app.background:
        _wanted.update(name for name, *_ in _known)
        _look_soon(PAUSE)


def of(armature: bpy.types.Object) -> Readiness:
    """The readiness of a character; slow for a large rig the first time, and after it was changed."""
    return _look_at(armature).ready


def mapping(armature: bpy.types.Object) -> Mapping | None:
    """The bones that :func:`of` found, without those that are locked; None where they are not enough."""
    return _look_at(armature).mapping


def made_of(armature: bpy.types.Object) -> tuple:
    """What a rig is made of as far as its mapping hangs on it: equal while it stays the same."""
    return _look_at(armature).made_of


def known(armature: bpy.types.Object) -> Readiness | None:
    """The readiness as far as it has been worked out, None where it has not. For drawing: never slow.

    What has changed since is looked at as soon as Blender is idle. Without a window nothing is ever idle, so that is now.
    """
    if bpy.app.background:
        return of(armature)
    found = _known.get(_key(armature))
    if found is None or found.seen != _changes:
        later(armature, 0.0 if found is None else PAUSE)
    return found and found.ready


def later(armature: bpy.types.Object, seconds: float = 0.0) -> None:
    """Work out the readiness as soon as Blender is idle, but not before so many seconds."""
    _wanted.add(armature.name)
    _look_soon(seconds)


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
    """A part's name as a heading, as Blender names sides: "Upper Arm L"."""
    side, _, rest = part.partition("_")
    named = f"{rest}_{side[0]}" if side in ("left", "right") else part
    return named.replace("_", " ").title()


def _key(armature) -> tuple:
    """What is cheap to see and may change without Blender telling: locks do."""
    data = armature.animation_data
    tweaked = data is not None and data.use_tweak_mode
    facts = len(armature.data.bones), len(armature.s2ag.bone_map), armature.mode == "EDIT", tweaked
    return armature.name, *facts, _locks(armature).tobytes()


def _locks(armature) -> np.ndarray:
    """Which rotations are locked (3 n,)."""
    pose = armature.pose.bones if armature.pose else ()
    locks = np.zeros(3 * len(pose), bool)
    if len(pose):
        pose.foreach_get("lock_rotation", locks)
    return locks


def _look_at(armature) -> _Look:
    key = _key(armature)
    found = _known.get(key)
    if found is not None and found.seen == _changes:
        return found
    made_of = state(armature)
    if found is not None and found.made_of == made_of:
        found = replace(found, seen=_changes)
    else:
        forget(armature)
        found = _Look(*_look(armature), made_of, _changes)
    _known[key] = found
    return found


def state(armature: bpy.types.Object) -> tuple:
    """All of a rig that a readiness is worked out from, in a form that two looks can be compared by; quick."""
    if armature.type != "ARMATURE":
        return ()
    bones = reading.read(armature)
    arrays = bones.parents, bones.matrices, bones.lengths, bones.inherits, bones.driven, _locks(armature)
    chosen = tuple((item.name, item.bones) for item in armature.s2ag.bone_map), armature.s2ag.bone_map_notes
    standing = armature.data.pose_position, armature.library is None, str(vrm.humanoid(armature))
    return bones.names, *(array.tobytes() for array in arrays), chosen, standing


def _look(armature) -> tuple[Readiness, Mapping | None]:
    try:
        reading.require_armature(armature)
        mapping, refusal = reading.survey(armature, handpicked.chosen(armature.s2ag))
    except S2agError as error:
        return Readiness(problem=told_error(error)), None
    found = {one.part: one for one in mapping.findings}
    moved = {part: tuple(name for name in chain if name not in mapping.held) for part, chain in mapping.chains.items()}
    rows = [_row(part, moved.get(part, ()), found.get(part)) for part in EDGE_NAMES]
    names = {family.key: family.name for family in families()}
    family = names.get(mapping.family, mapping.family)
    problem = "" if refusal is None else told_error(refusal)
    return Readiness(tuple(rows), family, mapping.warnings, problem), None if problem else mapping


def _row(part: str, bones: tuple[str, ...], found: Finding | None) -> Row:
    if bones:
        return Row(part, bones, True)
    known = found.note if found is not None else ""
    return Row(part, (), False, known or (told("needed") if part in ARMS else told("stays as it is")))


def catch_up() -> None:
    """Look at what is wanted, and draw what has become of it."""
    names = list(_wanted)
    _wanted.clear()
    news = False
    for name in names:
        armature = bpy.data.objects.get(name)
        if armature is not None and armature.type == "ARMATURE":
            before = _known.get(_key(armature))
            now = of(armature)
            news |= before is None or before.ready is not now
    for window in bpy.context.window_manager.windows if news else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _look_soon(seconds: float) -> None:
    if not bpy.app.timers.is_registered(catch_up):
        bpy.app.timers.register(catch_up, first_interval=seconds)
