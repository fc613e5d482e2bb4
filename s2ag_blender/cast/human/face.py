"""The human's face: shape keys by ARKit's names, teeth and tongue, as kept in ``face.npz``; made by :mod:`pack_face`."""

import functools
import zipfile
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ....core.errors import RigUnusable
from ..surface import Surface, to_object
from . import data

FACE = Path(__file__).with_name("face.npz")
MOVE = 2e-5
"""Metres between the places that a point can be moved to."""
_DROPS, _BACK, _NARROW = (0.0055, 0.0075, 0.007), (-0.0035, -0.0015, 0.003), (0.80, 0.78, 0.9)
"""Metres by which upper teeth, lower teeth and tongue are too high and too far in front, and how wide they should be."""
_BENT = 15.0
"""Metres by which an arch should lie farther back for each square metre aside, for corners of lips are before eye teeth."""
_LIP = 0.3
"""Of the lips' mask, what parts inside and outside."""
_LID = 0.006
"""Metres by which a blink moves the middle of a lid at least."""
SURFACES = ("helper-upper-teeth", "helper-lower-teeth", "helper-tongue")


def surface(name: str) -> np.ndarray:
    """Quads ``(n, 4)`` of one of :data:`SURFACES`, as rows of the base mesh."""
    return data.restored(_kept()[f"faces {name}"], 4).astype(int)


def bite(points: np.ndarray) -> np.ndarray:
    """``points`` (n, 3) of a person with teeth and tongue where a mouth has them: edges meet at the line between the lips.

    Those of the base mesh overlap, stand in the way of the lower lip and come out at the corners of a closed mouth.
    """
    moved = points.copy()
    for name, drop, back, narrow in zip(SURFACES, _DROPS, _BACK, _NARROW, strict=True):
        rows = np.unique(surface(name))
        moved[rows] = moved[rows] * (narrow, 1, 1) + (0, back, -drop)
        moved[rows, 1] += _BENT * moved[rows, 0] ** 2
    return moved


def inside(faces: np.ndarray, lips: np.ndarray, count: int) -> np.ndarray:
    """Which ``faces`` (m, 4) of a body are the inside of its mouth: what the ``lips`` (m, 4) part from the rest of it."""
    beside = faces[~(lips > _LIP).all(1)]
    labels = np.arange(count)
    while True:
        lowest = labels.copy()
        np.minimum.at(lowest, beside.ravel(), np.repeat(labels[beside].min(1), 4))
        lowest = lowest[lowest]  # in long strides
        if (lowest == labels).all():
            break
        labels = lowest
    outer = np.bincount(labels[beside.ravel()]).argmax()
    return (labels[faces] != outer).all(1) & ~(lips > _LIP).any(1)


def lids(faces: np.ndarray, count: int) -> np.ndarray:
    """How much of a lid (m, 4) the corners of ``faces`` are, rows of ``count`` points: what blinks move far."""
    far = np.zeros(count)
    for name in ("eyeBlinkLeft", "eyeBlinkRight"):
        rows, moves = units()[name]
        np.maximum.at(far, rows, np.linalg.norm(moves, axis=1))
    return np.clip(far / _LID, 0, 1)[faces]


def units() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """By name, rows ``(n,)`` of the base mesh and how far a unit moves them, ``(n, 3)`` metres, z up, facing -y."""
    kept = _kept()
    names = [name.removeprefix("rows ") for name in kept if name.startswith("rows ")]
    return {name: (np.cumsum(kept[f"rows {name}"], dtype=int), _moves(kept[f"moves {name}"])) for name in names}


def add_fine_keys(item, mesh: Surface, used: np.ndarray, subdivisions: int, collection: bpy.types.Collection) -> None:
    """The same on an object that was made of ``mesh``, whose points are the rows ``used``, and subdivided."""
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


def add_keys(item, points: np.ndarray, used: np.ndarray) -> None:
    """Shape keys on a mesh object whose vertices are the rows ``used`` of the base mesh ``points``, if any of them moves."""
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


def _add(item, name: str, coordinates: np.ndarray) -> None:
    if item.data.shape_keys is None:
        item.shape_key_add(name="Basis", from_mix=False)
        item.data.shape_keys.name = f"{item.name} keys"
    block = item.shape_key_add(name=name, from_mix=False)
    block.data.foreach_set("co", coordinates)
    block.value = 0.0


def _moves(planes: np.ndarray) -> np.ndarray:
    return data.joined(planes).view(np.int16).reshape(3, -1).T * MOVE


@functools.lru_cache(maxsize=1)
def _kept() -> dict[str, np.ndarray]:
    try:
        with np.load(FACE, allow_pickle=False) as file:
            return dict(file)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise RigUnusable("The human's face data cannot be read.", "Install the extension again.") from error
