"""The shape of a character's trunk and thighs, read from the meshes that its bones carry."""

import bpy
import numpy as np

from ...core.motion.skeleton import EDGE_NAMES
from ...rigs.plain import Bones, Mapping
from ...rigs.proportions import Girth, measure

VERTICES = 6000
"""As many of a character's vertices are looked at, evenly spread."""
_ENOUGH = 60
"""Vertices of a trunk from which on it counts as measured."""
_ON_EDGES = (0.25, 0.5, 0.75)
"""Where on an edge its points are."""


def read(armature: bpy.types.Object, bones: Bones, mapping: Mapping) -> Girth | None:
    """The trunk and what is below it at rest as the armature's meshes show it, or None where they do not."""
    trunk = _trunk_bones(bones, mapping)
    items = meshes(armature)
    step = max(1, -(-sum(len(item.data.vertices) for item in items) // VERTICES))
    points = [_points(armature, item, trunk, step) for item in items]
    points = np.concatenate([np.zeros((0, 3)), *points])
    return measure(bones, mapping, points) if len(points) >= _ENOUGH else None


def meshes(armature: bpy.types.Object) -> list[bpy.types.Object]:
    """Visible meshes that an armature modifier lets follow ``armature``."""
    return [
        item
        for item in bpy.data.objects
        if item.type == "MESH"
        and not item.hide_render
        and any(one.type == "ARMATURE" and one.object is armature and one.use_vertex_groups for one in item.modifiers)
    ]


def _trunk_bones(bones: Bones, mapping: Mapping) -> set[str]:
    """Names of the bones that lie nearer to spine and legs than to arms, shoulders, neck and head, whoever moves them."""
    chains = mapping.chains
    torso = [bones.heads[bones.row(name)] for name in (mapping.hips, *chains.get("torso", ())) if name in bones.names]
    shoulders = [bones.heads[bones.row(chains[f"{side}_upper_arm"][0])] for side in ("left", "right")]
    torso.append(mapping.end(bones, "torso") if "torso" in chains else 0.5 * (shoulders[0] + shoulders[1]))
    torso.insert(0, 2 * torso[0] - torso[-1])  # legs, and what is worn about them, hang as far below as the trunk is long
    lines = [(start, end, True) for start, end in zip(torso[:-1], torso[1:], strict=True)]
    for part in EDGE_NAMES[1:]:
        if part in chains:
            lines.append((bones.heads[bones.row(chains[part][0])], mapping.end(bones, part), False))
    if "head" in chains:
        crown = bones.heads[bones.row(chains["head"][-1])]
        lines.append((crown, crown + 0.5 * (crown - torso[1]), False))
    middles = 0.5 * (bones.heads + bones.tails)
    distances = np.array([_distance(middles, start, end) for start, end, _ in lines])
    nearest = np.array([is_trunk for *_, is_trunk in lines])[np.argmin(distances, axis=0)]
    below = {bones.row(chains[f"{side}_upper_arm"][0]) for side in ("left", "right")}
    for row, parent in enumerate(bones.parents):
        if int(parent) in below:
            below.add(row)
    return {name for row, name in enumerate(bones.names) if nearest[row] and row not in below}


def _distance(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distances (n,) of points to the line from ``start`` to ``end``."""
    along = end - start
    share = np.clip((points - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=-1)


def _points(armature, item, trunk: set[str], step: int) -> np.ndarray:
    """Every ``step``-th vertex (n, 3) of a mesh at rest, in armature space, if it follows a trunk bone more than any other.

    Where all are looked at, which may be few, with points on the edges between them.
    """
    mesh = item.data
    known = set(armature.data.bones.keys())
    groups = {group.index: group.name in trunk for group in item.vertex_groups if group.name in known}
    rows = []
    for vertex in (mesh.vertices[row] for row in range(0, len(mesh.vertices), step)):
        pulls = [(pull.weight, groups[pull.group]) for pull in vertex.groups if pull.group in groups]
        if pulls and max(pulls)[1] and max(pulls)[0] > 0:
            rows.append(vertex.index)
    points = in_armature(armature, item)
    if step > 1:
        return points[rows]
    edges = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", edges)
    edges = edges.reshape(-1, 2)
    starts, ends = (points[ends] for ends in edges[np.isin(edges, rows).all(-1)].T)
    return np.concatenate([points[rows], *(starts + share * (ends - starts) for share in _ON_EDGES)])


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
