"""Films known motions for ``s2ag evaluate --capture``: one character, seen by several cameras and in several lights.

``python -m s2ag.s2ag_blender.render.capture_films JOB.json`` with the fields ``character``, ``gender``, ``fps``,
``resolution`` and ``shots``: each a ``motion`` (.npz), ``camera`` (four numbers as of ``core/learning/capture/filmed.py``, or
such for each frame), ``light`` (a studio light of Blender, and the exposure in stops) and ``output`` (.mp4). With ``look``, a
number, colours and girth are drawn by chance, and edges are rough: films to learn from.
"""

import sys
from collections.abc import Sequence
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core import json_text
from ...core.motion.motion import Motion
from .. import program
from ..characters.character import Character
from . import stage

_GIRTH, _SKIN = (-0.006, 0.014), np.array([0.75, 0.5, 0.38])
"""Metres by which clothes become wider, and a colour of skin."""
_KEPT = "eye", "iris"
"""Parts of names of materials whose colours are kept."""
_HIGHEST = 1.08
"""The highest height seen, in body heights."""


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(json_text.read(path), voice))


def perform(job: dict, voice: program.EventWriter) -> dict:
    """Film every shot of the job; return the ``result`` event's content. Raises S2agError."""
    from ..characters import loading
    from ..keys.apply import apply_motion
    from . import render

    scene, characters, _ = loading.build_scene([(job["character"], job.get("gender", "female"), None, None)])
    character = characters[0]
    scene.render.fps = job["fps"]
    stage.set_up_scene(scene, characters, tuple(job["resolution"]))
    settings: Any = scene
    settings.render.engine = "BLENDER_WORKBENCH"
    place, bodies = stage.Place.of(character), {item.name: _surface(item) for item in character.meshes}
    for number, shot in enumerate(job["shots"]):
        motion = Motion.load(shot["motion"])
        apply_motion(character.armature, motion, 1, scene=scene, mapping=character.mapping)
        scene.frame_start, scene.frame_end = 1, int((len(motion.directions) - 1) / motion.fps * job["fps"]) + 1
        _stand(scene, place, shot["camera"])
        settings.display.shading.studio_light, settings.view_settings.exposure = shot["light"]
        if "look" in shot:
            _disguise(scene, character, bodies, np.random.default_rng(shot["look"]))
        share = lambda done, number=number: voice.progress("film", (number + done) / len(job["shots"]))  # noqa: E731
        render.film(scene, shot["output"], render.Look(samples=1 if "look" in shot else None), share)
    return {"outputs": [shot["output"] for shot in job["shots"]]}


def _stand(scene: bpy.types.Scene, place: stage.Place, camera: Sequence) -> None:
    """Put the camera at one place, or on a way: a place for each frame."""
    item: Any = scene.camera
    item.animation_data_clear()
    if not isinstance(camera[0], Sequence):
        return _aim(scene, place, *camera)
    item.rotation_mode = "QUATERNION"
    for number, spot in enumerate(camera):
        _aim(scene, place, *spot)
        for path in ("location", "rotation_quaternion"):
            item.keyframe_insert(path, frame=scene.frame_start + number)
    return None


def _surface(item: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and normals ``(n, 3)`` of a mesh."""
    vertices = item.data.vertices
    return np.array([one.co for one in vertices]), np.array([one.normal for one in vertices])


def _disguise(scene: bpy.types.Scene, character: Character, bodies: dict, random: np.random.Generator) -> None:
    """Colour a character and the backdrop, and make clothes wider or tighter."""
    girth, own, settings = random.uniform(*_GIRTH), character.meshes, cast(Any, scene)
    coloured = any(not item.name.startswith(("Human", "Mannequin")) for item in own)
    tone = _SKIN * random.uniform(0.2, 1.2)
    for item in settings.objects:
        skin = any(name in item.name.lower() for name in ("skin", "head"))
        colour = tone if skin else random.random(3) ** 1.5 * (1 if item in own else 0.6)
        if item.type == "MESH":
            item.color = (*colour, 1)
        if item in own and not skin:
            points, normals = bodies[item.name]
            scale = max(float(np.abs(np.array(item.matrix_world)[:3, :3]).max()), 1e-3)
            item.data.vertices.foreach_set("co", (points + normals * girth / scale).ravel())
            item.data.update()
    for material in bpy.data.materials if coloured else ():
        name = material.name.lower()
        if any(part in name for part in _KEPT):
            continue
        skin = any(part in name for part in ("skin", "head"))
        material.diffuse_color = (*(tone if skin else random.random(3) ** 1.5), 1)
    settings.display.shading.color_type = "MATERIAL" if coloured else ("TEXTURE" if random.random() < 0.6 else "OBJECT")


def _aim(scene: bpy.types.Scene, place: stage.Place, aside: float, above: float, lens: float, low: float) -> None:
    """Put the scene's camera where it sees the performer from ``low`` body heights up."""
    item: Any = scene.camera
    item.data.lens = lens
    shown = (_HIGHEST - low) * place.height
    tall = item.data.sensor_width / lens * scene.render.resolution_y / scene.render.resolution_x
    turn, tilt = np.radians(aside), np.radians(above)
    way = np.cos(tilt) * (np.cos(turn) * place.facing + np.sin(turn) * place.left) + [0, 0, np.sin(tilt)]
    aim = place.ground + [0, 0, (low + _HIGHEST) / 2 * place.height]
    spot = aim + shown / tall * way
    item.matrix_world = Matrix.LocRotScale(
        Vector(spot.tolist()), Vector((aim - spot).tolist()).to_track_quat("-Z", "Y"), None
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
