"""Builds the character ``mannequin``: an artist's figure of tapered limbs on a plain skeleton.

Bones and limbs are the data of ``mannequin.json``, which :mod:`mannequin_recipe` designs."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from ..datablocks import ArmatureObject, current_context
from . import materials, skinned_surface
from .character import Character

DATA = Path(__file__).with_name("mannequin.json")


def build(collection: bpy.types.Collection | None = None) -> Character:
    """Build the mannequin into a new collection of the current scene."""
    bones, names, body = _design()
    if collection is None:
        collection = bpy.data.collections.new("Mannequin")
        current_context().scene.collection.children.link(collection)
    armature = _armature(bones, collection)
    looks = [
        materials.plain("Mannequin body", (0.60, 0.56, 0.50), 0.45),
        materials.plain("Mannequin joint", (0.075, 0.085, 0.10), 0.35),
        materials.plain("Mannequin face", (0.028, 0.11, 0.14), 0.2),
    ]
    part = skinned_surface.to_object("Mannequin Body", body, names, looks, collection)
    skinned_surface.follow(part, armature)
    return Character(armature, (part,), collection)


@cache
def _design() -> tuple[list[tuple], list[str], skinned_surface.Surface]:
    """Return bones, their names and the body, which are the same for every mannequin."""
    design = json.loads(DATA.read_text("utf-8"))
    names = [name for name, *_ in design["bones"]]
    return design["bones"], names, _body(design["limbs"], names)


def _armature(bones: Sequence[tuple], collection: bpy.types.Collection) -> ArmatureObject:
    """Create the armature of ``bones``, each its name, head and tail in metres, and the name of its parent or None."""
    data = bpy.data.armatures.new("Mannequin")
    item = cast(ArmatureObject, bpy.data.objects.new("Mannequin", data))
    collection.objects.link(item)
    current_context().view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    tails = {name: tail for name, _, tail, _ in bones}
    for name, head, tail, parent in bones:
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        if parent:
            bone.parent = data.edit_bones[parent]
            bone.use_connect = bool(np.allclose(tails[parent], head))
    bpy.ops.object.mode_set(mode="OBJECT")
    return item


def _body(limbs: Sequence[Mapping], bones: list[str]) -> skinned_surface.Surface:
    """Return all limbs, each rigidly weighted to its bone."""
    weights = dict(zip(bones, np.eye(len(bones), dtype=np.float32), strict=True))
    parts = [skinned_surface.grid(_points(one), weights[one["bone"]], one["material"], closed=True) for one in limbs]
    whole = parts[0]
    for part in parts[1:]:
        whole = whole.joined(part)
    return whole


def _points(limb: Mapping) -> np.ndarray:
    """Return the points (rings, fine, 3) of a tapered limb from ``start`` to ``end``, rounded at both ends.

    Its ``profile`` is (share of the length, half width, half depth) of a few elliptic rings in metres, deep to ``front``."""
    head, fine = np.array(limb["start"]), limb["fine"]
    along = np.array(limb["end"]) - head
    share = (1 - np.cos(np.linspace(0.02, np.pi - 0.02, 6 + fine // 2))) / 2
    shares, widths, depths = np.array(limb["profile"]).T
    ends = (1 - np.abs(2 * share - 1) ** limb["roundness"]) ** (1 / limb["roundness"])
    ahead = np.array(limb["front"], float)
    ahead = ahead - along * (ahead @ along) / (along @ along)
    ahead = ahead / np.linalg.norm(ahead)
    side = np.cross(along, ahead) / np.linalg.norm(along)
    turn = np.linspace(0, 2 * np.pi, fine, endpoint=False)
    # through the few rings of the profile goes a polynomial
    wide, deep = (np.polyval(np.polyfit(shares, sizes, len(shares) - 1), share) * ends for sizes in (widths, depths))
    wide = wide[:, None, None] * np.cos(turn)[:, None] * side
    deep = deep[:, None, None] * np.sin(turn)[:, None] * ahead
    return head + share[:, None, None] * along + wide + deep
