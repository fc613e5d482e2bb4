"""Parameters of the engine that a plan has beside the character's settings: curves over time, and the partner."""

from collections.abc import Callable, Collection
from typing import Any

import bpy

from ...core.declaration import KINDS
from ...core.settings import CONTROLS, Settings, names_with, table
from ...rigs.skeleton import Mapping
from .. import json_properties
from ..datablocks import ArmatureObject
from ..translations import translate
from . import control_curves, menu_items, sources

TIMED, PARTNER = "over_time", "others"
"""Keys of time-varying controls and of the conversation partner in the settings of a take."""
_PARTNER_TYPES = {name: KINDS[table(Settings)[name].kind] for name in names_with(partner=True)}


def of_partner(kept: dict[str, Any] | None, look: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return the engine's parameters of the conversation partner, from ``kept`` settings of a take or by ``look``."""
    if not kept:
        return look()
    known = kept.get(PARTNER)
    known = {name: known[name] for name in _PARTNER_TYPES if name in known} if isinstance(known, dict) else {}
    return known if json_properties.has_types(known, _PARTNER_TYPES) else {}


def of_curves(
    armature: ArmatureObject, scene: bpy.types.Scene, span: sources.Span, kept: dict[str, Any] | None
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the engine's time-varying parameters, from ``kept`` settings of a take or as keyed now, and warnings."""
    if kept:
        timed = kept.get(TIMED)
        timed = timed if isinstance(timed, dict) else {}
        return {name: timed[name] for name in names_with(timed=True) if name in timed}, ()
    changes, unknown = control_curves.style_changes(armature, scene, span)
    params = {"curves": control_curves.sample_curves(armature, scene, span), "changes": changes}
    return {name: value for name, value in params.items() if value}, unknown


def of_busy_hands(armature: ArmatureObject, mapping: Mapping, parts: Collection[str]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the settings with which one hand talks for both while an arm is busy, and a warning where that was found.

    An arm is busy that is not among the ``parts``, is locked, or is held by a constraint to another object."""
    found = {arm for arm in ("LEFT_ARM", "RIGHT_ARM") if arm in parts and _is_held(armature, mapping, arm.lower()[:-4])}
    free = {"LEFT_ARM", "RIGHT_ARM"} & set(parts) - found
    one = {name: 1.0 if "RIGHT_ARM" in free else -1.0 for name in names_with(kind="side") if len(free) == 1}
    told = {"parts": sorted(set(parts) - found), **one}
    return told, (translate("An arm is held or locked: it stays as it is, and the other one talks."),) if found else ()


def _is_held(armature: ArmatureObject, mapping: Mapping, side: str) -> bool:
    arm = [name for part in ("upper_arm", "forearm") for name in mapping.chains.get(f"{side}_{part}", ())]
    bones = [bone for bone in armature.pose.bones if bone.name in {*arm, *mapping.chains.get(f"{side}_hand", ())}]
    acting = [one for bone in bones for one in bone.constraints if not one.mute and one.influence > 0]
    locked = any(all(bone.lock_rotation) for bone in bones if bone.name in arm)
    return locked or any(getattr(one, "target", None) not in (None, armature) for one in acting)


def drop_unknown_controls(params: dict[str, Any], settings: Any) -> tuple[str, ...]:
    """Remove sliders that the checkpoint does not have from the engine's parameters; return a warning if any was set."""
    if menu_items.control_names(settings):
        return ()
    removed = [params.pop(name, 0) for name in names_with(control=True)]
    rest = {name: points for name, points in params.pop("curves", {}).items() if name not in CONTROLS}
    params |= {"curves": rest} if rest else {}
    if not any(any(value.values()) if isinstance(value, dict) else value for value in removed):
        return ()
    return (translate("This gesture model has intensity only: the other sliders were left out."),)
