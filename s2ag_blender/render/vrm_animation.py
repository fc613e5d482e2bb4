"""Writes what a character does as a VRM animation (``.vrma``), for which its bones are named as a human's."""

import tempfile
from pathlib import Path

import bpy

from ...core.files import atomic_file
from ...core.motion import vrma
from ...rigs import fingers, legs
from ...rigs.proportions import SIDES
from ...rigs.skeleton import Bones, Mapping, character_frame
from ..characters.character import Character
from ..rig import reading
from . import export

_ARM = {"_clavicle": "Shoulder", "_upper_arm": "UpperArm", "_forearm": "LowerArm", "_hand": "Hand"}
_FINGERS = {4: ("Index", "Middle", "Ring", "Little"), 3: ("Index", "Middle", "Little"), 2: ("Index", "Little")}
_JOINTS, _THUMB = ("Proximal", "Intermediate", "Distal"), ("Metacarpal", "Proximal", "Distal")


def write(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    """Write ``path``; raises :class:`UsageError` for characters without legs."""
    armature = character.armature
    bones = reading.read(armature)
    humans = human_bones(bones, reading.resolve_mapping(armature, bones, character.mapping))
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        export.export(scene, character, Path(folder) / "bare.glb")
        content = vrma.from_glb((Path(folder) / "bare.glb").read_bytes(), humans)
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


def human_bones(bones: Bones, mapping: Mapping) -> dict[str, str]:
    """Return ``{human bone: bone}`` by VRM's names, as far as they are found."""
    torso = mapping.chains.get("torso", ())
    spine = {1: torso[:1], 2: torso[:2]}.get(len(torso), (*torso[:1], *torso[len(torso) // 2 :][:1], *torso[-1:]))
    found = dict(zip(("spine", "chest", "upperChest"), spine, strict=False))
    found |= {part: mapping.chains[part][0] for part in ("neck", "head") if mapping.chains.get(part)}
    left, _, up = character_frame(bones, mapping)
    pair = legs.find(bones, mapping, up)
    if pair is not None:
        found["hips"] = bones.names[pair.pelvis]
        for side, leg in zip(("right", "left"), sorted(pair.pair, key=lambda leg: bones.heads[leg.thigh] @ left), strict=True):
            for name, row in (("UpperLeg", leg.thigh), ("LowerLeg", leg.shin), ("Foot", leg.foot)):
                found[side + name] = bones.names[row]
    for side in SIDES:
        for part, name in _ARM.items():
            if chain := mapping.chains.get(side + part):
                found[side + name] = chain[-1 if part == "_clavicle" else 0]
        found |= _hand(bones, mapping, side)
    return found


def _hand(bones: Bones, mapping: Mapping, side: str) -> dict[str, str]:
    hand, found = fingers.find_hand(bones, mapping, side), {}
    for name, chain in zip(_FINGERS[len(hand.fingers)], hand.fingers, strict=True) if hand else ():
        found |= {f"{side}{name}{joint}": bones.names[row] for joint, row in zip(_JOINTS, chain, strict=False)}
    for joint, row in zip(_THUMB, hand.thumb, strict=False) if hand else ():
        found[f"{side}Thumb{joint}"] = bones.names[row]
    return found
