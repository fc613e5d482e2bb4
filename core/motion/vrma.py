"""Writes VRM animations: a binary glTF of a skeleton becomes one whose nodes are known as a human's bones.

The extension ``VRMC_vrm_animation`` 1.0 wants a T-pose at rest, rotations of human bones alone, and places of the hips. What
bones between two human bones turn, such as those that share an arm's twist, is given to the next human bone."""

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import UsageError
from . import quaternion, skeleton

EXTENSION = "VRMC_vrm_animation"
NEEDED = ("hips", "spine", "head", *(f"{side}{part}" for side in ("left", "right") for part in (
    "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot")))  # fmt: skip
"""Human bones without which there is no VRM animation."""
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
LAID = {"UpperArm": "LowerArm", "LowerArm": "Hand", "UpperLeg": "LowerLeg", "LowerLeg": "Foot", "Hand": "MiddleProximal"}
LAID |= {f"{finger}{joint}": f"{finger}{end}" for joint, end in (("Proximal", "Intermediate"), ("Intermediate", "Distal"))
         for finger in ("Index", "Middle", "Ring", "Little")}  # fmt: skip
LAID |= {"ThumbMetacarpal": "ThumbProximal", "ThumbProximal": "ThumbDistal"}
"""Bones that a T-pose lays straight, each with the one that it points at: arms, fingers aside, thumbs half ahead, legs down."""


def read_glb(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return document and binary part of a binary glTF."""
    (size,) = struct.unpack_from("<I", content, 12)
    return json.loads(content[20 : 20 + size]), content[28 + size :]


def write_glb(document: dict[str, Any], binary: bytes) -> bytes:
    """Return the binary glTF of a document and its binary part."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text, binary = text + b" " * (-len(text) % 4), binary + b"\0" * (-len(binary) % 4)
    parts = struct.pack("<II", len(text), _JSON) + text + struct.pack("<II", len(binary), _BINARY) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def from_glb(content: bytes, humans: Mapping[str, str]) -> bytes:
    """Return the VRM animation of a binary glTF with one animation; ``humans`` is ``{human bone: bone}``.

    Raises :class:`UsageError` where a bone that is needed is unknown."""
    missing = [name for name in NEEDED if name not in humans]
    if missing:
        raise UsageError(f"A VRM animation needs the bone {missing[0]}.", "Use a character with arms and legs.")
    tree = Tree(*read_glb(content))
    nodes = {human: tree.joint(name) for human, name in humans.items()}
    _face_ahead(tree, nodes)
    order = sorted(nodes, key=lambda human: len(tree.above(nodes[human])))
    turned, rest = _world(tree, tree.turned), _t_pose(tree, nodes, order)
    local: dict[str, np.ndarray] = {}
    for human in order:
        between = tree.between(nodes[human], set(nodes.values()))
        base = turned[between[-1]] if between and between[-1] in nodes.values() else np.array([1.0, 0, 0, 0])
        for node in reversed([one for one in between if one not in nodes.values()]):
            base = quaternion.multiply(base, tree.rest[node])
        local[human] = quaternion.continuous(quaternion.multiply(quaternion.conjugate(base), turned[nodes[human]]))
    for human in order:
        tree.nodes[nodes[human]]["rotation"] = _written(rest[human])
    return write_glb(*_document(tree, nodes, local))


class Tree:
    """Nodes of a glTF, their rotations at rest and in every frame, as quaternions with w first."""

    def __init__(self, document: dict[str, Any], binary: bytes) -> None:
        self.document, self.binary, self.nodes = document, binary, document["nodes"]
        self.parents = {child: number for number, node in enumerate(self.nodes) for child in node.get("children", ())}
        self.rest = [np.roll(np.array(node.get("rotation", (0.0, 0, 0, 1))), 1) for node in self.nodes]
        self.places = [np.array(node.get("translation", (0.0, 0, 0))) for node in self.nodes]
        self.sizes = [float(node.get("scale", (1.0,))[0]) for node in self.nodes]
        (animation,) = document["animations"]
        self.name = animation.get("name", "animation")
        moved = {(one["target"]["node"], one["target"]["path"]): animation["samplers"][one["sampler"]]
                 for one in animation["channels"]}  # fmt: skip
        self.times = np.unique(np.concatenate([self._read(one["input"]) for one in moved.values()]))
        self.turned = [self._sampled(moved.get((number, "rotation")), one) for number, one in enumerate(self.rest)]
        self.moved = [self._sampled(moved.get((number, "translation")), one) for number, one in enumerate(self.places)]

    def joint(self, name: str) -> int:
        """Return the node of a bone."""
        joints = self.document["skins"][0]["joints"]
        return next(number for number in joints if self.nodes[number].get("name") == name)

    def heads(self, local: Any) -> list[np.ndarray]:
        """Return where all nodes are, turned as ``local`` says."""
        world = _world(self, local)

        def of(node: int) -> np.ndarray:
            above = self.parents.get(node)
            if above is None:
                return self.places[node]
            size = self.sizes[above] * np.prod([self.sizes[one] for one in self.above(above)])
            return of(above) + quaternion.rotate(world[above], size * self.places[node])

        return [of(number) for number in range(len(self.nodes))]

    def above(self, node: int) -> list[int]:
        """Return the nodes above one, from its parent on."""
        found = []
        while (node := self.parents.get(node, -1)) >= 0:
            found.append(node)
        return found

    def between(self, node: int, known: set[int]) -> list[int]:
        """Return the nodes above one up to the first of ``known``, that one included."""
        above = self.above(node)
        return above[: next((place for place, one in enumerate(above) if one in known), len(above) - 1) + 1]

    def _read(self, number: int) -> np.ndarray:
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        values = np.frombuffer(self.binary, "<f4", accessor["count"] * width, start).astype(float)
        return values if width == 1 else values.reshape(-1, width)

    def _sampled(self, sampler: dict[str, Any] | None, rest: np.ndarray) -> np.ndarray:
        """Return values at all times; those at rest where nothing moves."""
        if sampler is None:
            return np.broadcast_to(rest, (len(self.times), len(rest)))
        at, values = self._read(sampler["input"]), self._read(sampler["output"])
        here = np.clip(np.searchsorted(at, self.times, "right") - 1, 0, max(len(at) - 2, 0))
        after = np.minimum(here + 1, len(at) - 1)
        share = np.clip((self.times - at[here]) / np.maximum(at[after] - at[here], 1e-9), 0, 1)[:, None]
        if len(rest) == 3:
            return values[here] + (values[after] - values[here]) * share
        turns = quaternion.continuous(np.roll(values, 1, -1))
        mixed = turns[here] + (turns[after] - turns[here]) * share
        return mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)


def _world(tree: Tree, local: Any) -> list[np.ndarray]:
    """Return the rotations of all nodes in the scene."""
    found: dict[int, np.ndarray] = {}

    def of(node: int) -> np.ndarray:
        if node not in found:
            above = tree.parents.get(node)
            found[node] = local[node] if above is None else quaternion.multiply(of(above), local[node])
        return found[node]

    return [of(number) for number in range(len(tree.nodes))]


def _t_pose(tree: Tree, nodes: dict[str, int], order: list[str]) -> dict[str, np.ndarray]:
    """Return the rotations of human bones at rest: arms, palms down, and fingers to the sides, legs down."""
    names = {node: human for human, node in nodes.items()}
    local = list(tree.rest)
    for human in order:
        side, part = ("left", human[4:]) if human.startswith("left") else ("right", human.removeprefix("right"))
        if part not in LAID or not human.startswith(("left", "right")) or side + LAID[part] not in nodes:
            continue
        aside, ahead = np.array([1.0 if side == "left" else -1.0, 0, 0]), np.array([0, 0, 1.0])
        wanted = np.array([0.0, -1, 0]) if part.endswith("Leg") else aside + ahead * part.startswith("Thumb")
        world, heads, node = _world(tree, local), tree.heads(local), nodes[human]
        turn = quaternion.swing(skeleton.normalize(heads[nodes[side + LAID[part]]] - heads[node]), skeleton.normalize(wanted))
        if part == "Hand" and {f"{side}IndexProximal", f"{side}LittleProximal"} <= nodes.keys():
            across = quaternion.rotate(turn, heads[nodes[f"{side}IndexProximal"]] - heads[nodes[f"{side}LittleProximal"]])
            turn = quaternion.multiply(quaternion.swing(skeleton.normalize(across - across @ aside * aside), ahead), turn)
        above = world[tree.parents[node]]
        local[node] = quaternion.multiply(quaternion.conjugate(above), quaternion.multiply(turn, world[node]))
    return {names[node]: local[node] for node in names}


def _face_ahead(tree: Tree, nodes: dict[str, int]) -> None:
    """Turn the scene about the vertical so that the character looks ahead (+Z), and put its hips above the origin."""
    hips, heads = nodes["hips"], tree.heads(tree.rest)
    left = heads[nodes["leftUpperLeg"]] - heads[nodes["rightUpperLeg"]]
    angle = np.arctan2(left[2], left[0])
    turn, top = np.array([np.cos(angle / 2), 0, np.sin(angle / 2), 0]), (hips, *tree.above(hips))[-1]
    away = quaternion.rotate(turn, heads[hips]) * [1, 0, 1]
    for turns, places in ((tree.rest, tree.places), (tree.turned, tree.moved)):
        turns[top], places[top] = quaternion.multiply(turn, turns[top]), quaternion.rotate(turn, places[top]) - away
    tree.nodes[top] |= {"rotation": _written(tree.rest[top]), "translation": tree.places[top].tolist()}


def _written(turn: np.ndarray) -> list[float]:
    """Return a quaternion as a glTF has it: w last, and nothing beyond 1, not by rounding either."""
    return np.clip(np.roll(skeleton.normalize(turn), -1), -1.0, 1.0).tolist()


def _document(tree: Tree, nodes: dict[str, int], local: dict[str, np.ndarray]) -> tuple[dict[str, Any], bytes]:
    """Return document and binary part with the animation of the human bones alone."""
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    parts: list[bytes] = []

    def add(values: np.ndarray, kind: str) -> int:
        raw = np.ascontiguousarray(values, "<f4")
        views.append({"buffer": 0, "byteOffset": sum(map(len, parts)), "byteLength": raw.nbytes})
        parts.append(raw.tobytes())
        bounds = {"min": [float(raw.min())], "max": [float(raw.max())]} if kind == "SCALAR" else {}
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(raw), "type": kind, **bounds})
        return len(accessors) - 1

    at, samplers, channels = add(tree.times, "SCALAR"), [], []
    moving = [(nodes[human], "rotation", np.roll(turns, -1, -1), "VEC4") for human, turns in local.items()]
    for node, path, values, kind in [*moving, (nodes["hips"], "translation", tree.moved[nodes["hips"]], "VEC3")]:
        samplers.append({"input": at, "output": add(values, kind), "interpolation": "LINEAR"})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})
    humanoid = {"humanBones": {human: {"node": node} for human, node in nodes.items()}}
    bare = [{key: value for key, value in node.items() if key not in ("skin", "mesh")} for node in tree.nodes]
    return {
        **{key: tree.document[key] for key in ("asset", "scene", "scenes")},
        "nodes": bare,
        "animations": [{"name": tree.name, "samplers": samplers, "channels": channels}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": sum(map(len, parts))}],
        "extensionsUsed": [EXTENSION],
        "extensions": {EXTENSION: {"specVersion": "1.0", "humanoid": humanoid}},
    }, b"".join(parts)
