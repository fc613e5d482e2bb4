"""Builds the character ``mannequin``: an artist's figure of tapered limbs on a plain skeleton, without any data files."""

from collections.abc import Iterator, Mapping, Sequence
from typing import cast

import bpy
import numpy as np

from ..datablocks import ArmatureObject, current_context
from . import materials, skinned_surface
from .character import Character

_Bones = dict[str, tuple[np.ndarray, np.ndarray, str | None]]
_Profile = Sequence[tuple[float, float, float]]

_BODY, _JOINT, _FACE = 0, 1, 2

_MIDDLE = {
    "hips": ((0, 0.005, 0.95), (0, 0.0, 1.06), None),
    "spine": ((0, 0.0, 1.06), (0, 0.005, 1.22), "hips"),
    "chest": ((0, 0.005, 1.22), (0, 0.015, 1.45), "spine"),
    "neck": ((0, 0.015, 1.45), (0, -0.005, 1.54), "chest"),
    "head": ((0, -0.005, 1.54), (0, -0.005, 1.78), "neck"),
}
_LEFT = {
    "shoulder": ((0.03, 0.01, 1.425), (0.175, 0.02, 1.42), "chest"),
    "upper_arm": ((0.175, 0.02, 1.42), (0.305, 0.03, 1.165), "shoulder"),
    "lower_arm": ((0.305, 0.03, 1.165), (0.395, -0.02, 0.945), "upper_arm"),
    "hand": ((0.395, -0.02, 0.945), (0.445, -0.055, 0.785), "lower_arm"),
    "thigh": ((0.095, 0.0, 0.93), (0.11, -0.01, 0.51), "hips"),
    "shin": ((0.11, -0.01, 0.51), (0.12, 0.025, 0.09), "thigh"),
    "foot": ((0.12, 0.025, 0.09), (0.13, -0.12, 0.02), "shin"),
}
"""Bones as (head, tail, parent) in metres; ``_LEFT`` exists twice, with .L and mirrored with .R."""

_LIMBS = {
    "hips": (-0.55, 1.0, 3.2, [(0, 0.100, 0.075), (0.5, 0.150, 0.105), (1, 0.110, 0.085)]),
    "spine": (-0.12, 1.1, 3.2, [(0, 0.100, 0.076), (0.5, 0.096, 0.074), (1, 0.110, 0.082)]),
    "chest": (-0.2, 0.98, 2.8, [(0, 0.110, 0.086), (0.35, 0.140, 0.108), (0.65, 0.160, 0.114), (1, 0.128, 0.076)]),
    "neck": (-0.25, 1.2, 5, [(0, 0.056, 0.054), (0.5, 0.044, 0.045), (1, 0.046, 0.048)]),
    "head": (-0.06, 1.0, 2.15, [(0, 0.066, 0.080), (0.35, 0.082, 0.100), (0.65, 0.094, 0.116), (1, 0.092, 0.112)]),
    "shoulder": (-0.15, 1.05, 3, [(0, 0.030, 0.036), (0.5, 0.038, 0.042), (1, 0.048, 0.046)]),
    "upper_arm": (0.06, 0.93, 3.5, [(0, 0.048, 0.050), (0.35, 0.050, 0.052), (1, 0.034, 0.035)]),
    "lower_arm": (0.08, 0.95, 3.5, [(0, 0.038, 0.038), (0.3, 0.040, 0.041), (1, 0.022, 0.026)]),
    "thigh": (0.03, 0.93, 3.5, [(0, 0.086, 0.088), (0.3, 0.084, 0.090), (1, 0.050, 0.052)]),
    "shin": (0.06, 0.96, 3.5, [(0, 0.050, 0.052), (0.3, 0.052, 0.062), (1, 0.030, 0.034)]),
}
"""Limbs around bones: from and to (shares of the bone), roundness of the ends, [(share, half width, half depth) metres]."""

_BALLS = {"spine": 0.078, "upper_arm": 0.049, "lower_arm": 0.036, "hand": 0.027, "thigh": 0.070, "shin": 0.050, "foot": 0.034}
_FINGERS = {
    "little": (-0.030, 0.070, 0.0085),
    "ring": (-0.010, 0.082, 0.0095),
    "middle": (0.010, 0.078, 0.0095),
    "index": (0.028, 0.062, 0.0085),
}
"""Sideways offset at the knuckles, length and radius in metres."""


def build(collection: bpy.types.Collection | None = None) -> Character:
    """Build the mannequin into a new collection of the current scene."""
    if collection is None:
        collection = bpy.data.collections.new("Mannequin")
        current_context().scene.collection.children.link(collection)
    bones = _bones()
    armature = _armature(bones, collection)
    looks = [
        materials.plain("Mannequin body", (0.60, 0.56, 0.50), 0.45),
        materials.plain("Mannequin joint", (0.075, 0.085, 0.10), 0.35),
        materials.plain("Mannequin face", (0.028, 0.11, 0.14), 0.2),
    ]
    part = skinned_surface.to_object("Mannequin Body", _body(bones), list(bones), looks, collection)
    skinned_surface.follow(part, armature)
    return Character(armature, (part,), collection)


def _bones() -> _Bones:
    """Return ``{name: (head, tail, parent or None)}`` of both sides."""
    bones: _Bones = {name: (np.array(head), np.array(tail), parent) for name, (head, tail, parent) in _MIDDLE.items()}
    for suffix, side in ((".L", 1), (".R", -1)):
        flip = np.array([side, 1, 1])
        for name, (head, tail, parent) in _LEFT.items():
            owner = parent if parent in _MIDDLE else parent + suffix
            bones[name + suffix] = (np.multiply(head, flip), np.multiply(tail, flip), owner)
        wrist, tip, _ = bones["hand" + suffix]
        for finger, (points, _) in _digits(wrist, tip, side).items():
            bones[f"{finger}_1{suffix}"] = (points[0], points[1], "hand" + suffix)
            bones[f"{finger}_2{suffix}"] = (points[1], points[2], f"{finger}_1{suffix}")
    return bones


def _armature(bones: _Bones, collection: bpy.types.Collection) -> ArmatureObject:
    data = bpy.data.armatures.new("Mannequin")
    item = cast(ArmatureObject, bpy.data.objects.new("Mannequin", data))
    collection.objects.link(item)
    current_context().view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail, parent) in bones.items():
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head.tolist(), tail.tolist()
        if parent:
            bone.parent = data.edit_bones[parent]
            bone.use_connect = bool(np.allclose(bones[parent][1], head))
    bpy.ops.object.mode_set(mode="OBJECT")
    return item


def _body(bones: _Bones) -> skinned_surface.Surface:
    """Return every limb and joint, each rigidly weighted to its bone."""
    names = list(bones)
    parts = []
    for name, (head, tail, _) in bones.items():
        weights = np.eye(len(names), dtype=np.float32)[names.index(name)]
        plain = name.split(".")[0]
        if plain in _LIMBS:
            start, end, roundness, profile = _LIMBS[plain]
            parts.append(_limb(head + start * (tail - head), head + end * (tail - head), profile, roundness, weights))
        if plain in _BALLS:
            parts.append(_ball(head, _BALLS[plain], weights))
        if plain == "hand":
            rows = {one: np.eye(len(names), dtype=np.float32)[row] for row, one in enumerate(names)}
            parts.extend(_hand(head, tail, name.removeprefix("hand"), rows))
        if plain == "foot":
            toe = tail + [0, 0, 0.016]
            profile = [(0, 0.034, 0.036), (0.6, 0.044, 0.030), (1, 0.040, 0.020)]
            parts.append(_limb(head + [0, 0.045, -0.045], toe, profile, 3, weights))
        if plain == "head":
            parts.extend(_face(head, tail, weights))
    whole = parts[0]
    for part in parts[1:]:
        whole = whole.joined(part)
    return whole


def _limb(
    head: np.ndarray, tail: np.ndarray, profile: _Profile, roundness: float, weights: np.ndarray, slot: int = _BODY,
    front: Sequence[float] | np.ndarray = (0, -1, 0), fine: int = 28
) -> skinned_surface.Surface:  # fmt: skip
    """Return a tapered limb: elliptic rings of (share of the length, half width, half depth), rounded at both ends."""
    along = tail - head
    share = (1 - np.cos(np.linspace(0.02, np.pi - 0.02, 6 + fine // 2))) / 2
    shares, widths, depths = np.array(profile).T
    ends = (1 - np.abs(2 * share - 1) ** roundness) ** (1 / roundness)
    ahead = np.asarray(front, float)
    ahead = ahead - along * (ahead @ along) / (along @ along)
    ahead = ahead / np.linalg.norm(ahead)
    side = np.cross(along, ahead) / np.linalg.norm(along)
    turn = np.linspace(0, 2 * np.pi, fine, endpoint=False)
    wide, deep = (_interpolate(share, shares, sizes) * ends for sizes in (widths, depths))
    wide = wide[:, None, None] * np.cos(turn)[:, None] * side
    deep = deep[:, None, None] * np.sin(turn)[:, None] * ahead
    return skinned_surface.grid(head + share[:, None, None] * along + wide + deep, weights, slot, closed=True)


def _interpolate(at: np.ndarray, places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Evaluate the polynomial through the few ``values`` at ``places`` at positions ``at`` (n,)."""
    return np.polyval(np.polyfit(places, values, len(places) - 1), at)


def _ball(centre: np.ndarray, radius: float, weights: np.ndarray, slot: int = _JOINT) -> skinned_surface.Surface:
    reach = np.array([0, 0, radius])
    return _limb(centre - reach, centre + reach, [(0, radius, radius), (1, radius, radius)], 2, weights, slot)


def _frame(wrist: np.ndarray, tip: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit vectors (3,) along a hand, out of its palm, and across it to the thumb."""
    along = (tip - wrist) / np.linalg.norm(tip - wrist)
    palm = np.array([-side * 0.9, 0.1, -0.2])
    palm -= along * (palm @ along)
    palm /= np.linalg.norm(palm)
    across = np.cross(along, palm) * side
    return along, palm, across * np.sign(-across[1])


def _digits(wrist: np.ndarray, tip: np.ndarray, side: int) -> dict[str, tuple[np.ndarray, tuple[float, float]]]:
    """Return ``{finger: (knuckle, joint and tip (3, 3), radii of both links)}`` of slightly curled fingers and a thumb."""
    along, palm, across = _frame(wrist, tip, side)
    digits = {}
    for finger, (offset, length, radius) in _FINGERS.items():
        knuckle = wrist + 0.09 * along + offset * across
        bend = knuckle + 0.5 * length * (along + 0.22 * palm + 2.0 * offset * across)
        end = bend + 0.55 * length * (0.85 * along + 0.6 * palm)
        digits[finger] = np.array([knuckle, bend, end]), (radius, 0.9 * radius)
    root = wrist + 0.03 * along + 0.026 * across
    bend = root + 0.04 * along + 0.03 * across + 0.012 * palm
    end = bend + 0.036 * along + 0.006 * across + 0.010 * palm
    return digits | {"thumb": (np.array([root, bend, end]), (0.011, 0.0095))}


def _hand(
    wrist: np.ndarray, tip: np.ndarray, suffix: str, weights: Mapping[str, np.ndarray]
) -> Iterator[skinned_surface.Surface]:
    """Yield a palm on the hand's bone, four fingers and a thumb on bones of their own."""
    side = 1 if suffix == ".L" else -1
    along, palm, _ = _frame(wrist, tip, side)
    profile, own = [(0, 0.024, 0.020), (0.6, 0.038, 0.017), (1, 0.040, 0.013)], weights["hand" + suffix]
    yield _limb(wrist, wrist + 0.1 * along, profile, 4, own, front=palm)
    for finger, (points, radii) in _digits(wrist, tip, side).items():
        for link in (0, 1):
            yield _finger(points[link], points[link + 1], radii[link], weights[f"{finger}_{link + 1}{suffix}"])


def _finger(start: np.ndarray, end: np.ndarray, radius: float, weights: np.ndarray) -> skinned_surface.Surface:
    reach = (end - start) / np.linalg.norm(end - start) * radius * 0.6
    return _limb(start - reach, end + reach, [(0, radius, radius), (1, 0.85 * radius, 0.85 * radius)], 3, weights, fine=12)


def _face(neck: np.ndarray, crown: np.ndarray, weights: np.ndarray) -> Iterator[skinned_surface.Surface]:
    """Yield a visor and the hint of a nose, which show where the head faces."""
    height = crown[2] - neck[2]
    eyes = neck + [0, -0.058, 0.53 * height]
    visor = [(0, 0.022, 0.046), (0.5, 0.032, 0.062), (1, 0.022, 0.046)]
    yield _limb(eyes - [0.076, 0, 0], eyes + [0.076, 0, 0], visor, 3, weights, _FACE)
    nose = neck + [0, -0.103, 0.36 * height]
    yield _limb(nose + [0, 0.012, 0.034], nose + [0, -0.006, -0.014], [(0, 0.006, 0.008), (1, 0.014, 0.014)], 3, weights)
