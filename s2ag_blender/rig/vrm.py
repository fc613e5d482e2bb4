"""The humanoid map that the VRM add-on keeps on an armature, of VRM 0 or 1, whether the add-on is installed here or not."""

import re

import bpy

from ...rigs.plain import ARMS, Finding, Mapping
from .. import compat

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
        for part, bone in {
            "clavicle": "shoulder",
            "upper_arm": "upper_arm",
            "forearm": "lower_arm",
            "hand": "hand",
        }.items()
    },
}


def humanoid(armature: bpy.types.Object) -> Mapping | None:
    """The mapping that a VRM character brings along, or None. Bones that do not exist (any more) are left out."""
    extension = compat.stored(armature.data, EXTENSION)
    if extension is None:
        return None
    maps = [_newer(armature.data, extension), _older(armature.data, extension)]
    if str(_member(extension, "spec_version")) in ("0.0", "0"):
        maps.reverse()
    bones, chains = max(maps, key=len), {}
    for one in maps:
        if {bone for part in ARMS for bone in _PARTS[part]} <= set(one):
            bones = one
            break
    for part, humans in _PARTS.items():
        if chain := tuple(bones[human] for human in humans if human in bones):
            chains[part] = chain
    if not chains:
        return None
    findings = tuple(Finding(part, chain, "map") for part, chain in chains.items())
    hips = chains.pop("hips", ("",))[0]
    return Mapping(chains, FAMILY, hips, findings=findings)


def _newer(data, extension) -> dict[str, str]:
    """Bones by human bone, as VRM 1 keeps them: one member for each."""
    humans = _path(extension, "vrm1", "humanoid", "human_bones")
    names = {name for humans_of in _PARTS.values() for name in humans_of}
    found = {name: _bone(data, _path(humans, name, "node")) for name in names}
    return {name: bone for name, bone in found.items() if bone}


def _older(data, extension) -> dict[str, str]:
    """Bones by human bone, as VRM 0 keeps them: a list of pairs, in camel case."""
    found = {}
    for entry in _path(extension, "vrm0", "humanoid", "human_bones") or ():
        name = re.sub(r"(?<!^)([A-Z])", r"_\1", str(_member(entry, "bone") or "")).lower()
        if bone := _bone(data, _member(entry, "node")):
            found.setdefault(name, bone)
    return found


def _bone(data, node) -> str:
    """The name of an existing bone that a node of the map means, by its name or by its mark; "" for none."""
    for key in ("bone_name", "value"):
        name = _member(node, key)
        if isinstance(name, str) and name in data.bones:
            return name
    mark = _member(node, "bone_uuid")
    for bone in data.bones if mark else ():
        if _member(compat.stored(bone, EXTENSION), "uuid") == mark:
            return bone.name
    return ""


def _path(holder, *keys):
    for key in keys:
        holder = _member(holder, key)
    return holder


def _member(holder, key: str):
    """A member of registered properties or of plain data; None where there is none."""
    if holder is None:
        return None
    if isinstance(holder, bpy.types.bpy_struct):
        return getattr(holder, key, None)
    return holder.get(key) if hasattr(holder, "get") else None
