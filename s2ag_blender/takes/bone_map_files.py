"""Bone maps that the user chooses: started from what was found, loaded from and saved to files of ``s2ag rig``."""

import functools
import json
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ...core.errors import RigUnusable
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import maps
from ...rigs.detect import ROWS
from ...rigs.skeleton import Mapping, part_phrase
from ..datablocks import ArmatureObject
from ..rig import chosen_bones, readiness, reading

ORDER = (*ROWS, "crown")
"""Parts that a map may name, in the order of the panel."""
ALWAYS_SHOWN = ("hips", *EDGE_NAMES, "left_hand", "right_hand")
"""Parts that always have a row; twist bones and the crown have one only where the map names some."""


@functools.cache  # Blender keeps no reference to the texts of a menu
def parts() -> list[tuple[str, str, str]]:
    """Return the items of a menu of all parts."""
    return [(part, readiness.label(part), "") for part in ORDER]


def edit(armature: ArmatureObject) -> None:
    """Start a bone map from all detected bones, so that nothing changes yet; keep a map that is there."""
    if not armature.s2ag.bone_map:
        _fill(armature.s2ag, reading.detect_mapping(armature, reading.read(armature))[0])
        readiness.clear_cache(armature)


def reset(armature: ArmatureObject) -> None:
    """Go back to the detected bones."""
    armature.s2ag.bone_map.clear()
    armature.s2ag.bone_map_notes = ""
    readiness.clear_cache(armature)


def load(armature: ArmatureObject, path: str | Path) -> Mapping:
    """Load a bone map from a file and return it. Incomplete maps are allowed: the panel shows what is missing.

    Raises :class:`RigUnusable`, before changing anything, if the file is no bone map or names bones the armature lacks."""
    mapping = maps.load(path)
    _require_bones(armature, mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {}))
    armature.s2ag.bone_map.clear()
    _fill(armature.s2ag, mapping)
    readiness.clear_cache(armature)
    return mapping


def _fill(settings: Any, mapping: Mapping) -> None:
    """Store a mapping as the bone map of the settings."""
    chains = mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {})
    for part in ORDER:
        if part in chains or part in ALWAYS_SHOWN:
            item = settings.bone_map.add()
            item.name, item.bones = part, chosen_bones.join(chains.get(part, ()))
    switches = [{"bone": one.bone, "path": one.path, "value": one.value} for one in mapping.switches]
    settings.bone_map_notes = json.dumps({"family": mapping.family, "switches": switches})


def save(armature: ArmatureObject, path: str | Path) -> Mapping:
    """Write the chosen bones, else the detected ones, as a bone map file; return the map.

    Raises :class:`OutputUnwritable`, and :class:`RigUnusable` if a bone is in two parts."""
    mapping = chosen_bones.mapping_of_settings(armature.s2ag)
    if mapping is None:
        mapping, _ = reading.survey(armature)
    elif not isinstance(mapping, Mapping):
        mapping = reading.mapping_by_hand(armature, reading.read(armature), mapping)
    maps.parse(json.loads(maps.dump(mapping)))  # do not write what cannot be loaded
    maps.save(path, mapping, armature.name)
    return mapping


def _require_bones(armature: ArmatureObject, chains: dict[str, tuple[str, ...]]) -> None:
    """Raise :class:`RigUnusable` if the armature lacks bones of ``chains``."""
    names = [bone.name for bone in armature.data.bones]
    present = set(names)
    missing = [(part, bone) for part, chain in chains.items() for bone in chain if bone not in present]
    if not missing:
        return
    part, bone = missing[0]
    if len(missing) == 1:
        near = get_close_matches(bone, names, 1)
        hint = f'Did you mean "{near[0]}"?' if near else "Correct the bone map."
        raise RigUnusable(f'The armature has no bone "{bone}" for {part_phrase(part)}.', hint)
    total = sum(map(len, chains.values()))
    raise RigUnusable(
        f'The armature lacks {len(missing)} of the {total} bones of this map, "{bone}" among them.', "Load the map of this rig."
    )
