"""The shape of a character's trunk, thighs and head, read from the meshes that its bones carry."""

from dataclasses import replace

import bpy
import numpy as np

from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import skull
from ...rigs.plain import Bones, Mapping
from ...rigs.proportions import Girth, measure

VERTICES = 6000
"""As many of a character's vertices are looked at, evenly spread."""
_ENOUGH = 60
"""Vertices of a trunk from which on it counts as measured."""
_ON_EDGES = (0.25, 0.5, 0.75)
"""Where on an edge its points are."""


def read(armature: bpy.types.Object, bones: Bones, mapping: Mapping) -> Girth | None:
    """The trunk, what is below it and the head at rest as the armature's meshes show them, or None where they do not."""
    items, groups = meshes(armature), _bones(bones, mapping)
    step = max(1, -(-sum(len(item.data.vertices) for item in items) // VERTICES))
    found = [[np.zeros((0, 3))] * len(groups), *(_points(armature, item, groups, step) for item in items)]
    trunk, head = (np.concatenate(parts) for parts in zip(*found, strict=True))
    if len(trunk) < _ENOUGH:
        return None
    return replace(measure(bones, mapping, trunk), skull=skull.measure(bones, mapping, head))


def meshes(armature: bpy.types.Object) -> list[bpy.types.Object]:
    """Visible meshes that an armature modifier lets follow ``armature``."""
    return [
        item
        for item in bpy.data.objects
        if item.type == "MESH"
        and not item.hide_render
        and any(one.type == "ARMATURE" and one.object is armature and one.use_vertex_groups for one in item.modifiers)
    ]


def _bones(bones: Bones, mapping: Mapping) -> tuple[set[str], set[str]]:
    """Names of the bones that lie nearest to spine and legs, and of those nearest to the head, whoever moves them."""
    chains = mapping.chains
    torso = [bones.heads[bones.row(name)] for name in (mapping.hips, *chains.get("torso", ())) if name in bones.names]
    shoulders = [bones.heads[bones.row(chains[f"{side}_upper_arm"][0])] for side in ("left", "right")]
    torso.append(mapping.end(bones, "torso") if "torso" in chains else 0.5 * (shoulders[0] + shoulders[1]))
    torso.insert(0, 2 * torso[0] - torso[-1])  # legs, and what is worn about them, hang as far below as the trunk is long
    lines = [(start, end, "trunk") for start, end in zip(torso[:-1], torso[1:], strict=True)]
    for part in EDGE_NAMES[1:]:
        if part in chains:
            lines.append((bones.heads[bones.row(chains[part][0])], mapping.end(bones, part), part))
    if "head" in chains:
        crown = bones.heads[bones.row(chains["head"][-1])]
        lines.append((crown, crown + 0.5 * (crown - torso[1]), "skull"))
    middles = 0.5 * (bones.heads + bones.tails)
    distances = np.array([_distance(middles, start, end) for start, end, _ in lines])
    nearest = np.array([name for *_, name in lines])[np.argmin(distances, axis=0)]
    arms = _below(bones, [chains[f"{side}_upper_arm"][0] for side in ("left", "right")])
    head = (set(np.flatnonzero(nearest == "skull")) | _below(bones, chains.get("head", ())[-1:])) - arms
    trunk = set(np.flatnonzero(nearest == "trunk")) - arms
    return {bones.names[row] for row in trunk}, {bones.names[row] for row in head}


def _below(bones: Bones, names) -> set[int]:
    """Rows of the bones of these names and of all that hang on them."""
    found = {bones.row(name) for name in names}
    for row, parent in enumerate(bones.parents):
        if int(parent) in found:
            found.add(row)
    return found


def _distance(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distances (n,) of points to the line from ``start`` to ``end``."""
    along = end - start
    share = np.clip((points - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=-1)


def _points(armature, item, bones: tuple[set[str], ...], step: int) -> tuple[np.ndarray, ...]:
    """Every ``step``-th vertex (n, 3) of a mesh at rest, in armature space, that follows one of the ``bones`` most, for each
    set of them.

    Where all are looked at, which may be few, with points on the edges between them.
    """
    mesh = item.data
    known = set(armature.data.bones.keys())
    names = {group.index: group.name for group in item.vertex_groups if group.name in known}
    ruled, vertices = {}, mesh.vertices
    for row in range(0, len(vertices), step):
        weight, name = max(
            ((pull.weight, names[pull.group]) for pull in vertices[row].groups.values() if pull.group in names), default=(0, "")
        )
        if weight > 0:
            ruled[row] = name
    points = in_armature(armature, item)
    parts = [[row for row, name in ruled.items() if name in part] for part in bones]
    between = [_on_edges(mesh, points, rows) if step == 1 else [] for rows in parts]
    return tuple(np.concatenate([points[rows].reshape(-1, 3), *more]) for rows, more in zip(parts, between, strict=True))


def _on_edges(mesh, points: np.ndarray, rows: list[int]) -> list[np.ndarray]:
    """Points (n, 3) on the edges between vertices of these ``rows``."""
    edges = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", edges)
    edges = edges.reshape(-1, 2)
    starts, ends = (points[ends] for ends in edges[np.isin(edges, rows).all(-1)].T)
    return [starts + share * (ends - starts) for share in _ON_EDGES]


def in_armature(armature: bpy.types.Object, item: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) of a mesh at rest in armature space."""
    to_armature = np.array(armature.matrix_world.inverted_safe() @ item.matrix_world)
    return _shape(item.data) @ to_armature[:3, :3].T + to_armature[:3, 3]


def _shape(mesh: bpy.types.Mesh) -> np.ndarray:
    """Vertices (n, 3) of a mesh as its shape keys mix them now."""

    def coordinates(vertices):
        values = np.empty(3 * len(vertices), np.float32)
        vertices.foreach_get("co", values)
        return values.reshape(-1, 3).astype(float)

    keys = mesh.shape_keys
    if keys is None or not keys.use_relative:
        return coordinates(mesh.vertices)
    shape = coordinates(keys.reference_key.data)
    for key in keys.key_blocks:
        if key.value and not key.mute and key != keys.reference_key:
            shape = shape + key.value * (coordinates(key.data) - coordinates(key.relative_key.data))
    return shape
