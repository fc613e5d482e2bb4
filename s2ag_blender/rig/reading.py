"""Reading an armature object into the numpy structures of ``rigs``, and what stands in the way of keying it."""

import functools
import re
from dataclasses import replace

import bpy
import numpy as np

from ...core.errors import RigUnusable
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import chains as arm_chains
from ...rigs.detect import survey as detect_all
from ...rigs.plain import ARMS, MARKS, TWISTS, Bones, Finding, Mapping, spoken
from . import skin, vrm

_DRIVEN_BONE = re.compile(r'^pose\.bones\["((?:[^"\\]|\\.)*)"\]')

_IDLE = ("LIMIT_", "COPY_LOCATION", "COPY_SCALE", "MAINTAIN_VOLUME", "FLOOR", "SHRINKWRAP", "FOLLOW_PATH")
"""Beginnings of the types of constraints that do not turn a bone."""


def read(armature: bpy.types.Object) -> Bones:
    """The bones of an armature object at rest, in armature space, in its own (parents first) order."""
    bones = list(armature.data.bones)
    rows = {bone.name: row for row, bone in enumerate(bones)}
    posed = armature.pose.bones if armature.pose else ()  # a new armature has no pose yet
    ruled = _driven_bones(armature).union(bone.name for bone in posed if any(map(_turns, bone.constraints)))
    return Bones(
        tuple(rows),
        np.array([rows[bone.parent.name] if bone.parent else -1 for bone in bones], int),
        np.array([bone.matrix_local for bone in bones], float).reshape(-1, 4, 4),
        np.array([bone.length for bone in bones], float),
        np.array([bone.use_inherit_rotation for bone in bones], bool),
        np.array([name in ruled for name in rows], bool),
    )


def require_armature(armature: bpy.types.Object) -> None:
    """Raise :class:`RigUnusable` unless ``armature`` is an armature object whose action may be set now."""
    if armature is None or armature.type != "ARMATURE":
        name = "Nothing" if armature is None else f'"{armature.name}"'
        raise RigUnusable(f"{name} is not an armature.", "Choose the character's armature object.")
    if armature.library is not None:
        raise RigUnusable(f'"{armature.name}" is linked from another file.', "Make a library override of it first.")
    if armature.mode == "EDIT":
        raise RigUnusable(f'"{armature.name}" is in edit mode.', "Leave edit mode first.")
    if armature.animation_data is not None and armature.animation_data.use_tweak_mode:
        raise RigUnusable(
            f'An NLA strip of "{armature.name}" is being edited.', "Leave tweak mode first: Tab in the NLA editor."
        )


def survey(armature: bpy.types.Object, mapping: Mapping | dict | None = None) -> tuple[Mapping, RigUnusable | None]:
    """What is known of an armature, and why that is not enough, or None; changes and raises nothing."""
    bones = read(armature)
    if mapping is None:
        mapping, refusal = found(armature, bones)
        if refusal is not None:
            return mapping, refusal
    elif not isinstance(mapping, Mapping):
        mapping = by_hand(armature, bones, mapping)
    try:
        return resolve_mapping(armature, bones, mapping), None
    except RigUnusable as error:
        known = set(bones.names)
        strange = [replace(one, how="", note="no such bone") for one in mapping.findings if not known.issuperset(one.bones)]
        named = {one.part: one for one in strange}
        return replace(mapping, findings=tuple(named.get(one.part, one) for one in mapping.findings)), error


def found(
    armature: bpy.types.Object, bones: Bones, seen: arm_chains.Reader | None = None
) -> tuple[Mapping, RigUnusable | None]:
    """What is found of an armature by itself, locked bones included, and why that is not enough, or None.

    ``seen`` looks at its skin, and is the same for those that ask together: a look takes its time.
    """
    return detect_all(bones, f'Armature "{armature.name}"', vrm.humanoid(armature), seen or _skin(armature, bones))


def _skin(armature, bones: Bones) -> arm_chains.Reader:
    """What looks at the skin when it is first asked."""
    return functools.cache(lambda: skin.read(armature, bones))


def resolve_mapping(armature: bpy.types.Object, bones: Bones, mapping: Mapping | dict | None = None) -> Mapping:
    """The mapping to use: the given one (``{part: bone or bones}``) or the detected one; locked bones stay as they are.

    Its ``warnings`` tell of everything that keeps a part from moving as asked. Raises :class:`RigUnusable`.
    """
    seen = _skin(armature, bones)
    if mapping is None:
        mapping, refusal = found(armature, bones, seen)
        if refusal is not None:
            raise refusal
    elif not isinstance(mapping, Mapping):
        mapping = by_hand(armature, bones, mapping)
    mapping = _without_locked(armature, mapping.check(bones))
    if not mapping.shares:
        mapping = replace(mapping, shares=arm_chains.twist_shares(bones, mapping.chains, seen))
    return replace(mapping, warnings=(*mapping.warnings, *_obstacles(armature, mapping)))


def by_hand(armature: bpy.types.Object, bones: Bones, chosen: dict) -> Mapping:
    """A mapping of ``{part: bone or bones}``, with the hips, hands and switches of the kind of rig whose arms it has.

    Where a forearm ends must be known: where the map does not say it and other arms are found, the bone that carries
    most below the forearm is taken for the hand.
    """
    chains = {part: (chain,) if isinstance(chain, str) else tuple(chain) for part, chain in chosen.items()}
    mapping = Mapping({part: chain for part, chain in chains.items() if chain})
    seen, refusal = found(armature, bones)
    if refusal is not None or any(seen.chains[part] != mapping.chains.get(part) for part in ARMS):
        return replace(mapping, chains=arm_chains.with_hands(bones, mapping.chains))
    taken = {name for chain in mapping.chains.values() for name in chain}
    marks = {part: seen.chains[part] for part in MARKS if part in seen.chains and not taken.intersection(seen.chains[part])}
    return replace(mapping, chains=marks | mapping.chains, hips=mapping.hips or seen.hips, switches=seen.switches)


def is_locked(bone: bpy.types.PoseBone) -> bool:
    """Whether no rotation of ``bone`` may be keyed; a free w alone, as new bones have it, turns nothing."""
    return all(bone.lock_rotation)


def _without_locked(armature, mapping: Mapping) -> Mapping:
    pose, moved = armature.pose.bones, (*EDGE_NAMES, *TWISTS)
    locked = [name for part in moved for name in mapping.chains.get(part, ()) if is_locked(pose[name])]
    if not locked:
        return mapping
    free = {part: tuple(name for name in mapping.chains.get(part, ()) if name not in locked) for part in moved}
    still = [part for part in ARMS if not free[part]]  # where the arms are tells where the character's left and front are
    chains = {
        part: kept for part, chain in mapping.chains.items() if (kept := chain if part in still else free.get(part, chain))
    }
    held = mapping.held.union(name for part in still for name in chains[part])
    findings = tuple(_unlocked(one, free) if one.part in moved else one for one in mapping.findings)
    stays = "they stay as they are" if len(locked) > 1 else "it stays as it is"
    warnings = (*mapping.warnings, f"{_quoted(locked)}: rotation is locked, so {stays}.")
    return replace(mapping, chains=chains, warnings=warnings, findings=findings, held=held)


def _unlocked(finding: Finding, chains: dict) -> Finding:
    """The finding without bones that are not in ``chains``, which its note tells."""
    kept = chains.get(finding.part, ())
    if kept == finding.bones:
        return finding
    note = f"{_quoted([name for name in finding.bones if name not in kept])}: rotation is locked"
    return replace(finding, bones=kept, how=finding.how if kept else "", note=note)


def _obstacles(armature, mapping: Mapping) -> list[str]:
    pose = armature.pose.bones
    warnings = []
    if armature.data.pose_position == "REST":
        warnings.append(f'Armature "{armature.name}" shows its rest position, so motion will not be seen.')
    for part in ARMS:
        partly = [name for name in mapping.chains[part] if any(pose[name].lock_rotation) and name not in mapping.held]
        if partly:
            warnings.append(f"{_quoted(partly)}: {spoken(part)} cannot point everywhere, part of its rotation is locked.")
    return warnings


def _turns(constraint) -> bool:
    """Whether a constraint rules how its bone turns; limits only bound it, and some only move it."""
    return not constraint.mute and constraint.influence > 0 and not constraint.type.startswith(_IDLE)


def _driven_bones(armature) -> set[str]:
    drivers = armature.animation_data.drivers if armature.animation_data else ()
    paths = [driver.data_path for driver in drivers if "rotation" in driver.data_path]
    return {bpy.utils.unescape_identifier(found[1]) for path in paths if (found := _DRIVEN_BONE.match(path))}


def _quoted(names: list[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:4])
    return f"Bones {shown} and {len(names) - 4} more" if len(names) > 4 else f"Bone{'s' * (len(names) > 1)} {shown}"
