"""Reads the humanoid bone map that the VRM add-on stores on an armature (VRM 0 or 1), even without the add-on installed."""

import re
from typing import Any

import bpy

from ...rigs.skeleton import ARMS, Finding, Mapping
from .. import compat
from ..datablocks import ArmatureObject

EXTENSION = "vrm_addon_extension"
FAMILY = "VRM humanoid map"
_PARTS = {
    "hips": ("hips",),
    "torso": ("spine", "chest", "upper_chest"),
    "neck": ("neck",),
    "head": ("head",),
    **{
        f"{side}_{part}": (f"{side}_{bone}",)
        for side in ("left", "right")
        for part, bone in {"clavicle": "shoulder", "upper_arm": "upper_arm", "forearm": "lower_arm", "hand": "hand"}.items()
    },
}


def humanoid(armature: ArmatureObject) -> Mapping | None:
    """Return the mapping that a VRM character defines, or None. Bones that do not exist (any more) are left out."""
    extension = compat.stored(armature.data, EXTENSION)
    if extension is None:
        return None
    maps = [_bones_of_vrm1(armature.data, extension), _bones_of_vrm0(armature.data, extension)]
    if str(_member(extension, "spec_version")) in ("0.0", "0"):
        maps.reverse()
    bones, chains = max(maps, key=len), {}
    for candidate in maps:
        if {bone for part in ARMS for bone in _PARTS[part]} <= set(candidate):
            bones = candidate
            break
    for part, humans in _PARTS.items():
        if chain := tuple(bones[human] for human in humans if human in bones):
            chains[part] = chain
    if not chains:
        return None
    findings = tuple(Finding(part, chain, "map") for part, chain in chains.items())
    hips = chains.pop("hips", ("",))[0]
    return Mapping(chains, FAMILY, hips, findings=findings)


def _bones_of_vrm1(data: bpy.types.Armature, extension: Any) -> dict[str, str]:
    """Return ``{human bone: bone}`` of VRM 1, which has one member for each human bone."""
    humans = _path(extension, "vrm1", "humanoid", "human_bones")
    names = {name for humans_of in _PARTS.values() for name in humans_of}
    bones = {name: _bone(data, _path(humans, name, "node")) for name in names}
    return {name: bone for name, bone in bones.items() if bone}


def _bones_of_vrm0(data: bpy.types.Armature, extension: Any) -> dict[str, str]:
    """Return ``{human bone: bone}`` of VRM 0, which has a list of pairs with names in camel case."""
    bones = {}
    for entry in _path(extension, "vrm0", "humanoid", "human_bones") or ():
        name = re.sub(r"(?<!^)([A-Z])", r"_\1", str(_member(entry, "bone") or "")).lower()
        if bone := _bone(data, _member(entry, "node")):
            bones.setdefault(name, bone)
    return bones


def _bone(data: bpy.types.Armature, node: Any) -> str:
    """Return the name of the existing bone that a node of the map refers to, by name or by UUID; "" for none."""
    for key in ("bone_name", "value"):
        name = _member(node, key)
        if isinstance(name, str) and name in data.bones:
            return name
    uuid = _member(node, "bone_uuid")
    for bone in data.bones if uuid else ():
        if _member(compat.stored(bone, EXTENSION), "uuid") == uuid:
            return bone.name
    return ""


def _path(holder: Any, *keys: str) -> Any:
    """Return the member at a path of ``keys``; None where there is none."""
    for key in keys:
        holder = _member(holder, key)
    return holder


def _member(holder: Any, key: str) -> Any:
    """Return a member of registered properties or of raw data; None where there is none."""
    if holder is None:
        return None
    if isinstance(holder, bpy.types.bpy_struct):
        return getattr(holder, key, None)
    return holder.get(key) if hasattr(holder, "get") else None
