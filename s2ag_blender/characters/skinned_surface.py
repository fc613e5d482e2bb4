"""Skinned surfaces as plain arrays, of which characters are built: cut, smooth, trim, and convert to Blender meshes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import bpy
import numpy as np

from ..datablocks import ArmatureObject, MeshObject, current_context


@dataclass(frozen=True)
class Surface:
    """Quads with bone weights.

    ``points`` (n, 3) metres; ``faces`` (m, 4) rows of points, a triangle repeats its last corner; ``weights`` (n, bones)
    float32; ``slots`` (m,) material index; ``uvs`` (m, 4, 2) or None."""

    points: np.ndarray
    faces: np.ndarray
    weights: np.ndarray
    slots: np.ndarray
    uvs: np.ndarray | None = None

    @classmethod
    def of(
        cls, points: np.ndarray, faces: np.ndarray, weights: np.ndarray, slot: int = 0, uvs: np.ndarray | None = None
    ) -> "Surface":
        """Create a surface of one material from the rows of ``points`` that ``faces`` uses."""
        used, inverse = np.unique(faces, return_inverse=True)
        return cls(points[used], inverse.reshape(faces.shape), weights[used], np.full(len(faces), slot), uvs)

    def kept(self, mask: np.ndarray) -> "Surface":
        """Return only the faces where ``mask`` (m,) is true, and the points they use."""
        used, inverse = np.unique(self.faces[mask], return_inverse=True)
        uvs = None if self.uvs is None else self.uvs[mask]
        return Surface(self.points[used], inverse.reshape(-1, 4), self.weights[used], self.slots[mask], uvs)

    def joined(self, other: "Surface") -> "Surface":
        """Return both surfaces as one; texture coordinates are kept only if both have them."""
        uvs = None if self.uvs is None or other.uvs is None else np.concatenate([self.uvs, other.uvs])
        return Surface(
            np.concatenate([self.points, other.points]),
            np.concatenate([self.faces, other.faces + len(self.points)]),
            np.concatenate([self.weights, other.weights]),
            np.concatenate([self.slots, other.slots]),
            uvs,
        )

    def edges(self) -> np.ndarray:
        """Return the directed edges (e, 2) in face order, without those of zero length."""
        edges = np.stack([self.faces, np.roll(self.faces, -1, 1)], -1).reshape(-1, 2)
        return edges[edges[:, 0] != edges[:, 1]]

    def normals(self) -> np.ndarray:
        """Return unit normals (n, 3) at the points, weighted by area."""
        a, b, c, d = np.moveaxis(self.points[self.faces], 1, 0)
        across = np.cross(c - a, d - b)
        normals = np.zeros_like(self.points)
        for corner in range(4):
            np.add.at(normals, self.faces[:, corner], across)
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)

    def offset(self, distance: float | np.ndarray) -> "Surface":
        """Move points along their normals by ``distance`` metres, one number or (n,)."""
        return replace(self, points=self.points + np.reshape(distance, (-1, 1)) * self.normals())

    def smoothed(self, rounds: int, amount: float | np.ndarray = 1.0) -> "Surface":
        """Apply Taubin smoothing, which does not shrink; borders stay. ``amount`` is 0..1, one number or (n,)."""
        amount = np.broadcast_to(np.reshape(amount, (-1, 1)), (len(self.points), 1)).copy()
        amount[border(self)[0]] = 0
        points = self.points.copy()
        for _ in range(rounds):
            for step in (0.5, -0.52):
                points += step * amount * (self._around(points) - points)
        return replace(self, points=points)

    def softened(self, rounds: int) -> "Surface":
        """Smooth the weights over neighbouring points, so that cloth bends gradually."""
        weights = self.weights
        for _ in range(rounds):
            weights = 0.5 * (weights + self._around(weights))
        return replace(self, weights=weights)

    @cached_property
    def _neighbours(self) -> tuple[np.ndarray, ...]:
        """Points that have neighbours, where each one's begin, how many they are (p,), and all neighbours (k,)."""
        edges = np.unique(np.sort(self.edges(), 1), axis=0)
        both = np.concatenate([edges, edges[:, ::-1]])
        both = both[np.argsort(both[:, 0], kind="stable")]
        return *np.unique(both[:, 0], return_index=True, return_counts=True), both[:, 1]

    def _around(self, values: np.ndarray) -> np.ndarray:
        """Return the mean (n, k) of ``values`` (n, k) over each point's neighbours."""
        points, starts, counts, others = self._neighbours
        mean = values.copy()
        mean[points] = np.add.reduceat(values[others], starts, axis=0) / counts[:, None]
        return mean


def border(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return the directed border edges as two arrays of points: (from, to)."""
    edges = surface.edges()
    size = len(surface.points)
    inside = np.isin(edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0])
    return edges[~inside, 0], edges[~inside, 1]


def loops(surface: Surface) -> list[np.ndarray]:
    """Return the border's closed loops, each as points (k,) in the direction of the border."""
    following = dict(zip(*(ends.tolist() for ends in border(surface)), strict=True))
    closed = []
    while following:
        loop = [next(iter(following))]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        closed.append(np.array(loop[:-1]))
    return closed


def cut(surface: Surface, distance: np.ndarray) -> Surface:
    """Keep the part where ``distance`` (n,) is positive, with its border exactly on zero.

    Points next to the zero line move onto it along their edges, so there are no slivers and quads stay quads except where
    the line crosses a corner. Texture coordinates are dropped."""
    distance = np.asarray(distance, float).copy()
    edges = np.unique(np.sort(surface.edges(), 1), axis=0)
    a, b = edges[distance[edges[:, 0]] * distance[edges[:, 1]] < 0].T
    near, far = np.where(np.abs(distance[a]) <= np.abs(distance[b]), (a, b), (b, a))
    share = distance[near] / (distance[near] - distance[far])
    order = np.argsort(-share)  # the shortest move to the line is written last and wins
    near, far, share = near[order], far[order], share[order, None]
    points, weights = surface.points.copy(), surface.weights.copy()
    points[near] = (1 - share) * surface.points[near] + share * surface.points[far]
    weights[near] = (1 - share) * surface.weights[near] + share * surface.weights[far]
    distance[near] = 0
    outside = distance[surface.faces] < 0
    faces, slots = surface.faces.copy(), surface.slots
    for corner in range(4):  # one corner outside: a triangle of the three others
        rows = outside[:, corner] & (outside.sum(1) == 1)
        faces[rows] = np.roll(surface.faces[rows], -corner - 1, 1)
        faces[rows, 3] = faces[rows, 2]
    positive = (distance[faces] >= 0).all(1) & (distance[faces] > 0).any(1)
    return Surface(points, faces, weights, slots).kept(positive)


def trim(surface: Surface, loop: np.ndarray, along: np.ndarray, steps: Sequence[tuple[float, float]], slot: int) -> Surface:
    """Extrude a band from a border loop: a cuff, a collar, a hem.

    ``along`` (3,) is the direction off the edge; each of ``steps`` is (metres along it, metres away from the loop's centre),
    measured from the loop. The first strip keeps the material of the surface, the others get ``slot``; all get the loop's
    weights."""
    ring = surface.points[loop]
    away = ring - ring.mean(0)
    away -= np.outer(away @ along, along)
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    count = len(loop)
    fresh = len(surface.points) + np.arange(len(steps) * count).reshape(-1, count)
    rings = np.concatenate([loop[None], fresh])
    here, there = rings[:-1], rings[1:]
    quads = np.stack([np.roll(here, -1, 1), here, there, np.roll(there, -1, 1)], -1).reshape(-1, 4)  # strip after strip
    return Surface(
        np.concatenate([surface.points, *(ring + ahead * along + out * away for ahead, out in steps)]),
        np.concatenate([surface.faces, quads]),
        np.concatenate([surface.weights, *[surface.weights[loop]] * len(steps)]),
        np.concatenate([surface.slots, np.full(count, surface.slots[0]), np.full(len(quads) - count, slot)]),
    )


def grid(points: np.ndarray, weights: np.ndarray, slot: int = 0, repeat: float = 1, closed: bool = False) -> Surface:
    """Create a tube from ``points`` (rows, columns, 3), its first row closed by a fan, its last too if ``closed``.

    Rows run from that lid along the tube, columns clockwise as seen from outside the lid. All points get ``weights``
    (bones,). Texture coordinates run once along and ``repeat`` times around."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    after = np.roll(index, -1, 1)
    u = np.arange(columns + 1) / columns * repeat
    v = np.linspace(0, 1, rows)
    faces = [np.stack([index[:-1], index[1:], after[1:], after[:-1]], -1).reshape(-1, 4)]
    left, right = (np.broadcast_to(edge, (rows - 1, columns)) for edge in (u[:-1], u[1:]))
    low, high = (np.broadcast_to(edge[:, None], (rows - 1, columns)) for edge in (v[:-1], v[1:]))
    sides = [np.stack(pair, -1) for pair in ((left, low), (left, high), (right, high), (right, low))]
    uvs = [np.stack(sides, -2).reshape(-1, 4, 2)]
    lids = [(index[0], after[0], points[0], 0.0)] + [(after[-1], index[-1], points[-1], 1.0)] * closed
    every = [points.reshape(-1, 3)]
    for here, there, ring, height in lids:
        tip = np.full(columns, rows * columns + len(every) - 1)
        faces.append(np.stack([tip, here, there, there], -1))
        uvs.append(np.repeat(np.stack([u[:-1], np.full(columns, height)], -1)[:, None], 4, 1))
        every.append(ring.mean(0, keepdims=True))
    every, faces = np.concatenate(every), np.concatenate(faces)
    skin = np.repeat(np.asarray(weights, np.float32)[None], len(every), 0)
    return Surface(every, faces, skin, np.full(len(faces), slot), np.concatenate(uvs))


def to_object(
    name: str, surface: Surface, bones: Sequence[str], materials: Sequence[bpy.types.Material],
    collection: bpy.types.Collection, subdivisions: int = 0
) -> MeshObject:  # fmt: skip
    """Create a smooth-shaded mesh object with vertex groups named after ``bones``; ``subdivisions`` are applied."""
    corners = surface.faces.tolist()
    corners = [face[:3] if face[2] == face[3] else face for face in corners]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(surface.points.tolist(), [], corners)
    for material in materials:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", surface.slots.astype(np.int32))
    if surface.uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        keep = np.ones(surface.faces.shape, bool)
        keep[:, 3] = surface.faces[:, 2] != surface.faces[:, 3]
        layer.data.foreach_set("uv", surface.uvs[keep].astype(np.float32).ravel())
    mesh.shade_smooth()
    item = cast(MeshObject, bpy.data.objects.new(name, mesh))
    collection.objects.link(item)
    _add_weights(item, surface.weights, bones)
    if subdivisions:
        _subdivide(item, subdivisions)
    return item


def follow(item: MeshObject, armature: ArmatureObject) -> None:
    """Make a mesh object a child of an armature that deforms it."""
    item.parent = armature
    modifier: Any = item.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature


def _add_weights(item: MeshObject, weights: np.ndarray, bones: Sequence[str]) -> None:
    """Add vertex groups with ``weights`` (n, bones), rounded to 1/512 so that equal weights are set in one call."""
    steps = np.rint(weights * 512).astype(int)
    for column, bone in enumerate(bones):
        rows = np.flatnonzero(steps[:, column])
        if not len(rows):
            continue
        group = item.vertex_groups.new(name=bone)
        order = rows[np.argsort(steps[rows, column], kind="stable")]
        values, starts = np.unique(steps[order, column], return_index=True)
        for value, same in zip(values, np.split(order, starts[1:]), strict=True):
            group.add(same.tolist(), value / 512, "REPLACE")


def _subdivide(item: MeshObject, levels: int) -> None:
    modifier: Any = item.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = levels
    current_context().view_layer.update()
    rough = item.data
    fine = bpy.data.meshes.new_from_object(item.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    item.modifiers.remove(modifier)
    item.data = fine
    fine.name = rough.name
    bpy.data.meshes.remove(rough)
