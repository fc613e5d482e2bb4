"""Adds the human's shape keys, named after ARKit, and places teeth and tongue; data is in ``face.npz`` (:mod:`pack_face`)."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...datablocks import MeshObject
from ..skinned_surface import Surface, to_object
from . import data

FACE = Path(__file__).with_name("face.npz")
MOVE = 2e-5
"""Resolution of stored offsets in metres."""
_LOWER, _SET_BACK, _SCALE_WIDTH = (0.0055, 0.0075, 0.007), (-0.0035, -0.0015, 0.003), (0.80, 0.78, 0.9)
"""Corrections of upper teeth, lower teeth and tongue: metres down, metres back, and scale of their width."""
_ARCH_BEND = 15.0
"""Metres by which an arch is moved back per square metre aside, so that its sides stay behind the corners of the lips."""
_LIP_THRESHOLD = 0.3
"""Faces with the lips' mask above this value separate the inside of the mouth from the outside."""
_LID_TRAVEL = 0.006
"""Least metres by which a blink moves the middle of a lid."""
SURFACES = ("helper-upper-teeth", "helper-lower-teeth", "helper-tongue")


def surface(name: str) -> np.ndarray:
    """Return the quads ``(n, 4)`` of one of :data:`SURFACES`, as rows of the base mesh."""
    return data.decode_rows(data.kept(FACE)[f"faces {name}"], 4).astype(int)


def align_teeth(points: np.ndarray) -> np.ndarray:
    """Return ``points`` (n, 3) of a person with teeth and tongue moved so that edges meet at the line between the lips.

    In the base mesh they overlap, intersect the lower lip and stick out at the corners of a closed mouth."""
    moved = points.copy()
    for name, drop, back, narrow in zip(SURFACES, _LOWER, _SET_BACK, _SCALE_WIDTH, strict=True):
        rows = np.unique(surface(name))
        moved[rows] = moved[rows] * (narrow, 1, 1) + (0, back, -drop)
        moved[rows, 1] += _ARCH_BEND * moved[rows, 0] ** 2
    return moved


def mouth_inside(faces: np.ndarray, lips: np.ndarray, count: int) -> np.ndarray:
    """Return which ``faces`` (m, 4) of a body are the inside of its mouth, which the mask ``lips`` (m, 4) separates."""
    beside = faces[~(lips > _LIP_THRESHOLD).all(1)]
    labels = np.arange(count)
    while True:
        lowest = labels.copy()
        np.minimum.at(lowest, beside.ravel(), np.repeat(labels[beside].min(1), 4))
        lowest = lowest[lowest]  # pointer jumping
        if (lowest == labels).all():
            break
        labels = lowest
    outer = np.bincount(labels[beside.ravel()]).argmax()
    return (labels[faces] != outer).all(1) & ~(lips > _LIP_THRESHOLD).any(1)


def lids(faces: np.ndarray, count: int) -> np.ndarray:
    """Return a mask (m, 4) of eyelids at the corners of ``faces``, rows of ``count`` points, by their travel in blinks."""
    far = np.zeros(count)
    for name in ("eyeBlinkLeft", "eyeBlinkRight"):
        rows, moves = units()[name]
        np.maximum.at(far, rows, np.linalg.norm(moves, axis=1))
    return np.clip(far / _LID_TRAVEL, 0, 1)[faces]


def units() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return ``{name: (rows (n,) of the base mesh, offsets (n, 3))}`` of the face units, in metres, z up, facing -y."""
    kept = data.kept(FACE)
    names = [name.removeprefix("rows ") for name in kept if name.startswith("rows ")]
    moves = {name: data.join_bytes(kept[f"moves {name}"]).view(np.int16).reshape(3, -1).T * MOVE for name in names}
    return {name: (np.cumsum(kept[f"rows {name}"], dtype=int), moves[name]) for name in names}


def add_fine_keys(
    item: MeshObject, mesh: Surface, used: np.ndarray, subdivisions: int, collection: bpy.types.Collection
) -> None:
    """Add shape keys to an object made of ``mesh``, whose points are the rows ``used``, and subdivided."""
    for name, (rows, moves) in units().items():
        mine, where = np.isin(rows, used), {row: place for place, row in enumerate(used.tolist())}
        if not mine.any():
            continue
        points = mesh.points.copy()
        points[[where[row] for row in rows[mine].tolist()]] += moves[mine]
        moved = to_object(name, replace(mesh, points=points), (), [], collection, subdivisions)
        flat = np.empty(3 * len(moved.data.vertices), np.float32)
        moved.data.vertices.foreach_get("co", flat)
        _add(item, name, flat)
        left = moved.data
        bpy.data.objects.remove(moved)
        bpy.data.meshes.remove(left)


def add_keys(item: MeshObject, points: np.ndarray, used: np.ndarray) -> None:
    """Add shape keys to a mesh object whose vertices are the rows ``used`` of the base mesh ``points``, if any moves."""
    where = np.full(len(points), -1)
    where[used] = np.arange(len(used))
    flat = np.empty(3 * len(used), np.float32)
    item.data.vertices.foreach_get("co", flat)
    rest = flat.reshape(-1, 3)
    for name, (rows, moves) in units().items():
        mine = where[rows] >= 0
        if not mine.any():
            continue
        moved = rest.copy()
        moved[where[rows[mine]]] += moves[mine]
        _add(item, name, moved.ravel())


def _add(item: MeshObject, name: str, coordinates: np.ndarray) -> None:
    """Add a shape key with ``coordinates`` (3 n,)."""
    if item.data.shape_keys is None:
        item.shape_key_add(name="Basis", from_mix=False)
        keys: Any = item.data.shape_keys
        keys.name = f"{item.name} keys"
    block: Any = item.shape_key_add(name=name, from_mix=False)
    block.data.foreach_set("co", coordinates)
    block.value = 0.0
