"""Works out and caches how ready a character is to gesture: which bones each body part maps to, and what is missing."""

from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np

from ...core.errors import S2agError
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import fingers
from ...rigs.family import families
from ...rigs.skeleton import ARMS, Bones, Finding, Mapping
from ..datablocks import ArmatureObject, current_context, is_armature
from ..translations import translate, translate_error
from . import chosen_bones, reading, vrm


@dataclass(frozen=True)
class Row:
    """One body part: its key, its bones, whether it has any, and a note about what prevents it."""

    part: str
    bones: tuple[str, ...]
    found: bool
    note: str = ""


@dataclass(frozen=True)
class Readiness:
    """Rows in the body's order, the rig family, warnings, a sentence saying why the rig cannot gesture at all, or "", and the
    bones from which the fingers of each hand begin, the thumb last.
    """

    rows: tuple[Row, ...] = ()
    family: str = ""
    warnings: tuple[str, ...] = ()
    problem: str = ""
    hands: tuple[Row, ...] = ()

    @property
    def found(self) -> int:
        """Return how many parts have bones."""
        return sum(row.found for row in self.rows)


@dataclass(frozen=True)
class _Look:
    """A cached result with the rig's :func:`state` and the change count for which it was worked out."""

    ready: Readiness
    mapping: Mapping | None
    made_of: tuple[Any, ...]
    seen: int


PAUSE = 0.3
"""Seconds to wait after a change before a readiness is worked out again."""

_cache: dict[tuple, _Look] = {}
_pending: set[str] = set()
_change_count = 0


def note_change(rigs: bool = False) -> None:
    """Note a change on which a readiness may depend; ``rigs`` if an armature itself changed.

    Called with every change of an object, so it only counts; the next lookup compares states."""
    global _change_count
    _change_count += 1
    if rigs and _cache and not bpy.app.background:
        _pending.update(name for name, *_ in _cache)
        _look_soon(PAUSE)


def readiness_of(armature: ArmatureObject) -> Readiness:
    """Return the readiness of a character; slow for a large rig the first time and after changes."""
    return look_at(armature).ready


def mapping(armature: ArmatureObject) -> Mapping | None:
    """Return the mapping behind :func:`readiness_of`, without locked bones; None where it is unusable."""
    return look_at(armature).mapping


def cached(armature: ArmatureObject) -> Readiness | None:
    """Return the cached readiness, None where there is none. For drawing: never slow.

    An outdated one is worked out again as soon as Blender is idle; in background mode, which has no idle time, at once."""
    if bpy.app.background:
        return readiness_of(armature)
    look = _cache.get(_cache_key(armature))
    if look is None or look.seen != _change_count:
        schedule(armature, 0.0 if look is None else PAUSE)
    return look and look.ready


def schedule(armature: ArmatureObject, seconds: float = 0.0) -> None:
    """Work out the readiness as soon as Blender is idle, but not before ``seconds`` have passed."""
    _pending.add(armature.name)
    _look_soon(seconds)


def stop() -> None:
    """Clear the cache and stop the timer; a timer that outlives the extension would hang Blender at exit."""
    clear_cache()
    if bpy.app.timers.is_registered(update_pending):
        bpy.app.timers.unregister(update_pending)


def clear_cache(armature: ArmatureObject | None = None) -> None:
    """Drop the cached readiness of a character (of all, if None)."""
    for key in [key for key in _cache if armature is None or key[0] == armature.name]:
        del _cache[key]
    _pending.clear()


def label(part: str) -> str:
    """Return a part's name as a heading with Blender's side suffix: "Upper Arm L"."""
    side, _, rest = part.partition("_")
    named = f"{rest}_{side[0]}" if side in ("left", "right") else part
    return named.replace("_", " ").title()


def _cache_key(armature: ArmatureObject) -> tuple[Any, ...]:
    """Return what is cheap to read and changes without a notification by Blender, such as locks."""
    data = armature.animation_data
    tweaked = data is not None and data.use_tweak_mode
    facts = len(armature.data.bones), len(armature.s2ag.bone_map), armature.mode == "EDIT", tweaked
    return armature.name, *facts, _locks(armature).tobytes()


def _locks(armature: ArmatureObject) -> np.ndarray:
    """Return which rotation channels are locked (3 n,)."""
    pose: Any = armature.pose.bones if armature.pose else ()
    locks = np.zeros(3 * len(pose), bool)
    if len(pose):
        pose.foreach_get("lock_rotation", locks)
    return locks


def look_at(armature: ArmatureObject) -> _Look:
    """Return the cached result, worked out again if the rig has changed."""
    key = _cache_key(armature)
    look = _cache.get(key)
    if look is not None and look.seen == _change_count:
        return look
    made_of = state(armature)
    if look is not None and look.made_of == made_of:
        look = replace(look, seen=_change_count)
    else:
        clear_cache(armature)
        look = _Look(*_work_out(armature), made_of, _change_count)
    _cache[key] = look
    return look


def state(armature: ArmatureObject) -> tuple[Any, ...]:
    """Return everything in a rig on which its readiness depends, as a tuple to compare; quick."""
    if armature.type != "ARMATURE":
        return ()
    bones = reading.read(armature)
    arrays = bones.parents, bones.matrices, bones.lengths, bones.inherits, bones.driven, _locks(armature)
    chosen = tuple((item.name, item.bones) for item in armature.s2ag.bone_map), armature.s2ag.bone_map_notes
    standing = armature.data.pose_position, armature.library is None, str(vrm.humanoid(armature))
    return bones.names, *(array.tobytes() for array in arrays), chosen, standing


def _work_out(armature: ArmatureObject) -> tuple[Readiness, Mapping | None]:
    try:
        reading.require_armature(armature)
        mapping, refusal = reading.survey(armature, chosen_bones.mapping_of_settings(armature.s2ag))
    except S2agError as error:
        return Readiness(problem=translate_error(error)), None
    findings = {finding.part: finding for finding in mapping.findings}
    moved = {part: tuple(name for name in chain if name not in mapping.held) for part, chain in mapping.chains.items()}
    rows = [_row(part, moved.get(part, ()), findings.get(part)) for part in EDGE_NAMES]
    names = {family.key: family.name for family in families()}
    family = names.get(mapping.family, mapping.family)
    problem = "" if refusal is None else translate_error(refusal)
    bones = reading.read(armature)
    hands = tuple(_fingers(bones, mapping, side) for side in fingers.SIDES)
    return Readiness(tuple(rows), family, mapping.warnings, problem, hands), None if problem else mapping


def _row(part: str, bones: tuple[str, ...], finding: Finding | None) -> Row:
    if bones:
        return Row(part, bones, True)
    note = finding.note if finding is not None else ""
    return Row(part, (), False, note or (translate("needed") if part in ARMS else translate("stays as it is")))


def _fingers(bones: Bones, mapping: Mapping, side: str) -> Row:
    """Return which bones the fingers of a hand begin with, the thumb's last."""
    hand = fingers.find_hand(bones, mapping, side)
    chains = (*hand.fingers, hand.thumb) if hand is not None else ()
    found = tuple(bones.names[chain[0]] for chain in chains if chain)
    return Row(f"{side}_fingers", found, bool(found), "" if found else translate("None: the hand moves as a whole"))


def update_pending() -> None:
    """Work out the pending readinesses, and redraw the 3D views if one of them changed."""
    names = list(_pending)
    _pending.clear()
    news = False
    for name in names:
        armature = bpy.data.objects.get(name)
        if is_armature(armature):
            before = _cache.get(_cache_key(armature))
            now = readiness_of(armature)
            news |= before is None or before.ready is not now
    for window in current_context().window_manager.windows if news else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _look_soon(seconds: float) -> None:
    if not bpy.app.timers.is_registered(update_pending):
        bpy.app.timers.register(update_pending, first_interval=seconds)
