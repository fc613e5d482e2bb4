"""Measures the shape of a character's trunk, thighs and head on the meshes that its bones deform."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, cast

import bpy
import numpy as np

from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import head_ellipsoid
from ...rigs.proportions import TrunkShape, measure_trunk
from ...rigs.skeleton import Bones, Mapping
from ..datablocks import ArmatureObject, MeshObject, is_mesh

VERTICES = 6000
"""Most vertices of a character that are sampled, evenly spread."""
_MIN_TRUNK_VERTICES = 60
"""A trunk with fewer vertices is not measured."""
_EDGE_SHARES = (0.25, 0.5, 0.75)
"""Positions of additional points on an edge, as shares of its length."""


def read_trunk(armature: ArmatureObject, bones: Bones, mapping: Mapping) -> TrunkShape | None:
    """Return the measures of trunk, thighs and head at rest from the armature's meshes, or None where those are too few."""
    items, groups = meshes(armature), _bones(bones, mapping)
    step = max(1, -(-sum(len(item.data.vertices) for item in items) // VERTICES))
    points = [[np.zeros((0, 3))] * len(groups), *(_points(armature, item, groups, step) for item in items)]
    trunk, head = (np.concatenate(parts) for parts in zip(*points, strict=True))
    if len(trunk) < _MIN_TRUNK_VERTICES:
        return None
    return replace(measure_trunk(bones, mapping, trunk), skull=head_ellipsoid.fit_head(bones, mapping, head))


def meshes(armature: ArmatureObject) -> list[MeshObject]:
    """Return the mesh objects, visible in renders, that an armature modifier deforms by the vertex groups of ``armature``."""

    def follows(modifier: Any) -> bool:
        return modifier.type == "ARMATURE" and modifier.object is armature and modifier.use_vertex_groups

    return [item for item in bpy.data.objects if is_mesh(item) and not item.hide_render and any(map(follows, item.modifiers))]


def vertex_weights(vertex: bpy.types.MeshVertex) -> list[bpy.types.VertexGroupElement]:
    """Return the indices and weights of the vertex groups of a vertex."""
    return cast(list[bpy.types.VertexGroupElement], vertex.groups.values())


def _bones(bones: Bones, mapping: Mapping) -> tuple[set[str], set[str]]:
    """Return the names of all bones nearest to spine and legs, and of those nearest to the head; arms belong to neither."""
    chains = mapping.chains
    torso = [bones.heads[bones.row(name)] for name in (mapping.hips, *chains.get("torso", ())) if name in bones.names]
    shoulders = [bones.heads[bones.row(chains[f"{side}_upper_arm"][0])] for side in ("left", "right")]
    torso.append(mapping.end(bones, "torso") if "torso" in chains else 0.5 * (shoulders[0] + shoulders[1]))
    torso.insert(0, 2 * torso[0] - torso[-1])  # legs and skirts reach as far below the hips as the trunk is long
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


def _below(bones: Bones, names: Iterable[str]) -> set[int]:
    """Return the rows of the bones of these names and of all their descendants."""
    rows = {bones.row(name) for name in names}
    for row, parent in enumerate(bones.parents):
        if int(parent) in rows:
            rows.add(row)
    return rows


def _distance(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the distances (n,) of points to the line segment from ``start`` to ``end``."""
    along = end - start
    share = np.clip((points - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=-1)


def _points(armature: ArmatureObject, item: MeshObject, bones: tuple[set[str], ...], step: int) -> tuple[np.ndarray, ...]:
    """Return, for each set of ``bones``, every ``step``-th vertex (n, 3) of a mesh whose largest weight is for one of them.

    Vertices are at rest, in armature space. With ``step`` 1, points on the edges between them are added, as a coarse mesh
    may have few vertices."""
    mesh = item.data
    bone_names = set(armature.data.bones.keys())
    names = {group.index: group.name for group in item.vertex_groups if group.name in bone_names}
    strongest, vertices = {}, mesh.vertices
    for row in range(0, len(vertices), step):
        pulls = ((one.weight, names[one.group]) for one in vertex_weights(vertices[row]) if one.group in names)
        weight, name = max(pulls, default=(0, ""))
        if weight > 0:
            strongest[row] = name
    points = in_armature(armature, item)
    parts = [[row for row, name in strongest.items() if name in part] for part in bones]
    between = [_on_edges(mesh, points, rows) if step == 1 else [] for rows in parts]
    return tuple(np.concatenate([points[rows].reshape(-1, 3), *more]) for rows, more in zip(parts, between, strict=True))


def _on_edges(mesh: bpy.types.Mesh, points: np.ndarray, rows: list[int]) -> list[np.ndarray]:
    """Return points (n, 3) on the edges between vertices of these ``rows``, for each of :data:`_EDGE_SHARES`."""
    edges = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", edges)
    edges = edges.reshape(-1, 2)
    starts, ends = (points[ends] for ends in edges[np.isin(edges, rows).all(-1)].T)
    return [starts + share * (ends - starts) for share in _EDGE_SHARES]


def in_armature(armature: ArmatureObject, item: MeshObject) -> np.ndarray:
    """Return the vertices (n, 3) of a mesh at rest in armature space."""
    to_armature = np.array(armature.matrix_world.inverted_safe() @ item.matrix_world)
    return _shape(item.data) @ to_armature[:3, :3].T + to_armature[:3, 3]


def _shape(mesh: bpy.types.Mesh) -> np.ndarray:
    """Return the vertices (n, 3) of a mesh with its current mix of shape keys."""

    def coordinates(vertices: Any) -> np.ndarray:
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
