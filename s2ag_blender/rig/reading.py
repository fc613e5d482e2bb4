"""Reads an armature object into the numpy structures of ``rigs``, and finds what prevents keying it."""

import functools
import re
from dataclasses import replace

import bpy
import numpy as np

from ...core.errors import RigUnusable
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import chains as arm_chains
from ...rigs.detect import survey as detect_all
from ...rigs.skeleton import ARMS, MARKS, TWISTS, Bones, Finding, Mapping, part_phrase
from ..datablocks import ArmatureObject
from . import skin, vrm

_DRIVEN_BONE = re.compile(r'^pose\.bones\["((?:[^"\\]|\\.)*)"\]')

_NOT_TURNING = ("LIMIT_", "COPY_LOCATION", "COPY_SCALE", "MAINTAIN_VOLUME", "FLOOR", "SHRINKWRAP", "FOLLOW_PATH")
"""Prefixes of the types of constraints that do not turn a bone."""


def read(armature: ArmatureObject) -> Bones:
    """Return the bones of an armature object at rest, in armature space, in its own (parents first) order."""
    bones = list(armature.data.bones)
    rows = {bone.name: row for row, bone in enumerate(bones)}
    posed = armature.pose.bones if armature.pose else ()  # a new armature has no pose yet
    controlled = _driven_bones(armature).union(bone.name for bone in posed if any(map(_turns, bone.constraints)))
    return Bones(
        tuple(rows),
        np.array([rows[bone.parent.name] if bone.parent else -1 for bone in bones], int),
        np.array([bone.matrix_local for bone in bones], float).reshape(-1, 4, 4),
        np.array([bone.length for bone in bones], float),
        np.array([bone.use_inherit_rotation for bone in bones], bool),
        np.array([name in controlled for name in rows], bool),
    )


def require_armature(armature: bpy.types.Object | None) -> None:
    """Raise :class:`RigUnusable` unless ``armature`` is an armature object whose action can be set now."""
    if armature is None or armature.type != "ARMATURE":
        name = "Nothing" if armature is None else f'"{armature.name}"'
        raise RigUnusable(f"{name} is not an armature.", "Choose the character's armature object.")
    if armature.library is not None:
        raise RigUnusable(f'"{armature.name}" is linked from another file.', "Make a library override of it first.")
    if armature.mode == "EDIT":
        raise RigUnusable(f'"{armature.name}" is in edit mode.', "Leave edit mode first.")
    bones = armature.pose.bones if armature.pose is not None else ()
    if not np.isfinite(np.array([armature.matrix_world, *(bone.matrix_basis for bone in bones)])).all():
        remedy = "Clear the transforms of the object and of its bones (Alt G, Alt R, Alt S)."
        raise RigUnusable(f'"{armature.name}" stands nowhere: a transform of it is no number.', remedy)
    if armature.animation_data is not None and armature.animation_data.use_tweak_mode:
        raise RigUnusable(
            f'An NLA strip of "{armature.name}" is being edited.', "Leave tweak mode first: Tab in the NLA editor."
        )


def survey(armature: ArmatureObject, mapping: Mapping | dict | None = None) -> tuple[Mapping, RigUnusable | None]:
    """Return the mapping of an armature and the error that makes it unusable, or None; changes and raises nothing."""
    bones = read(armature)
    if mapping is None:
        mapping, refusal = detect_mapping(armature, bones)
        if refusal is not None:
            return mapping, refusal
    elif not isinstance(mapping, Mapping):
        mapping = mapping_by_hand(armature, bones, mapping)
    try:
        return resolve_mapping(armature, bones, mapping), None
    except RigUnusable as error:
        names = set(bones.names)
        missing = [replace(one, how="", note="no such bone") for one in mapping.findings if not names.issuperset(one.bones)]
        by_part = {finding.part: finding for finding in missing}
        return replace(mapping, findings=tuple(by_part.get(one.part, one) for one in mapping.findings)), error


def detect_mapping(
    armature: ArmatureObject, bones: Bones, seen: arm_chains.Reader | None = None
) -> tuple[Mapping, RigUnusable | None]:
    """Detect the mapping of an armature, locked bones included; return it and the error that makes it unusable, or None.

    ``seen`` reads the skin weights; callers share one (see :func:`_skin`) because reading them is slow."""
    return detect_all(bones, f'Armature "{armature.name}"', vrm.humanoid(armature), seen or _skin(armature, bones))


def _skin(armature: ArmatureObject, bones: Bones) -> arm_chains.Reader:
    """Return a function that reads the skin weights at its first call."""
    return functools.cache(lambda: skin.read(armature, bones))


def resolve_mapping(armature: ArmatureObject, bones: Bones, mapping: Mapping | dict | None = None) -> Mapping:
    """Return the mapping to use: the given one (``{part: bone or bones}``) or the detected one, without locked bones.

    Its ``warnings`` name everything that keeps a part from moving freely. Raises :class:`RigUnusable`."""
    seen = _skin(armature, bones)
    if mapping is None:
        mapping, refusal = detect_mapping(armature, bones, seen)
        if refusal is not None:
            raise refusal
    elif not isinstance(mapping, Mapping):
        mapping = mapping_by_hand(armature, bones, mapping)
    mapping = _drop_locked(armature, mapping.check(bones))
    if not mapping.shares:
        mapping = replace(mapping, shares=arm_chains.twist_shares(bones, mapping.chains, seen))
    return replace(mapping, warnings=(*mapping.warnings, *_obstacles(armature, mapping)))


def mapping_by_hand(armature: ArmatureObject, bones: Bones, chosen: dict) -> Mapping:
    """Return a mapping of ``{part: bone or bones}``, with hips, hands and switches of the detected mapping if its arms agree.

    The end of each forearm must be known. If the map does not give it and detection finds other arms, the bone below the
    forearm with the most descendants is taken as the hand."""
    chains = {part: (chain,) if isinstance(chain, str) else tuple(chain) for part, chain in chosen.items()}
    mapping = Mapping({part: chain for part, chain in chains.items() if chain})
    seen, refusal = detect_mapping(armature, bones)
    if refusal is not None or any(seen.chains[part] != mapping.chains.get(part) for part in ARMS):
        return replace(mapping, chains=arm_chains.with_hands(bones, mapping.chains))
    taken = {name for chain in mapping.chains.values() for name in chain}
    marks = {part: seen.chains[part] for part in MARKS if part in seen.chains and not taken.intersection(seen.chains[part])}
    return replace(mapping, chains=marks | mapping.chains, hips=mapping.hips or seen.hips, switches=seen.switches)


def _drop_locked(armature: ArmatureObject, mapping: Mapping) -> Mapping:
    """Return the mapping without locked bones, with a warning; an arm that is all locked stays mapped but is held."""
    pose, moved = armature.pose.bones, (*EDGE_NAMES, *TWISTS)
    locked = [name for part in moved for name in mapping.chains.get(part, ()) if all(pose[name].lock_rotation)]
    if not locked:
        return mapping
    free = {part: tuple(name for name in mapping.chains.get(part, ()) if name not in locked) for part in moved}
    still = [part for part in ARMS if not free[part]]  # arms are needed to find the character's left and front
    chains = {
        part: kept for part, chain in mapping.chains.items() if (kept := chain if part in still else free.get(part, chain))
    }
    held = mapping.held.union(name for part in still for name in chains[part])
    findings = tuple(_drop_from_finding(one, free) if one.part in moved else one for one in mapping.findings)
    stays = "they stay as they are" if len(locked) > 1 else "it stays as it is"
    warnings = (*mapping.warnings, f"{_quoted(locked)}: rotation is locked, so {stays}.")
    return replace(mapping, chains=chains, warnings=warnings, findings=findings, held=held)


def _drop_from_finding(finding: Finding, chains: dict) -> Finding:
    """Return the finding without bones that are not in ``chains``, with a note about them."""
    kept = chains.get(finding.part, ())
    if kept == finding.bones:
        return finding
    note = f"{_quoted([name for name in finding.bones if name not in kept])}: rotation is locked"
    return replace(finding, bones=kept, how=finding.how if kept else "", note=note)


def _obstacles(armature: ArmatureObject, mapping: Mapping) -> list[str]:
    """Return warnings about a shown rest position and about partly locked arms."""
    pose = armature.pose.bones
    warnings = []
    if armature.data.pose_position == "REST":
        warnings.append(f'Armature "{armature.name}" shows its rest position, so motion will not be seen.')
    for part in ARMS:
        partly = [name for name in mapping.chains[part] if any(pose[name].lock_rotation) and name not in mapping.held]
        if partly:
            warnings.append(f"{_quoted(partly)}: {part_phrase(part)} cannot point everywhere, part of its rotation is locked.")
    return warnings


def _turns(constraint: bpy.types.Constraint) -> bool:
    """Return whether a constraint sets its bone's rotation; some only limit it or only move the bone."""
    return not constraint.mute and constraint.influence > 0 and not constraint.type.startswith(_NOT_TURNING)


def _driven_bones(armature: ArmatureObject) -> set[str]:
    """Return the names of the bones with a driver on their rotation."""
    drivers = armature.animation_data.drivers if armature.animation_data else ()
    paths = [driver.data_path for driver in drivers if "rotation" in driver.data_path]
    return {bpy.utils.unescape_identifier(match[1]) for path in paths if (match := _DRIVEN_BONE.match(path))}


def _quoted(names: list[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:4])
    return f"Bones {shown} and {len(names) - 4} more" if len(names) > 4 else f"Bone{'s' * (len(names) > 1)} {shown}"
