"""Films known motions for ``s2ag evaluate --capture``: one character, seen by several cameras and in several lights.

``python -m s2ag.s2ag_blender.render.capture_films JOB.json`` with the fields ``character``, ``gender``, ``fps``, ``resolution``
and ``shots``: each a ``motion`` (.npz), ``camera`` (:data:`CAMERAS`), ``light`` (:data:`LIGHTS`) and ``output`` (.mp4).
"""

import sys
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core import json_text
from ...core.motion.motion import Motion
from .. import program
from . import stage

CAMERAS = {
    "front": (6.0, 2.0, 60.0, 0.42),
    "desk": (-10.0, -7.0, 28.0, 0.46),
    "aside": (30.0, 11.0, 40.0, 0.42),
}
"""Degrees to the performer's left and upwards from where the performer looks, focal length in millimetres on a sensor of 36,
and the lowest height seen, in body heights: a long lens on a stand, a telephone on a desk, one held by somebody at the side."""
LIGHTS = {"studio": ("paint.sl", 0.0), "dim": ("rim.sl", -0.7)}
"""Blender's studio light, and the exposure in stops."""
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
    place = stage.Place.of(character)
    for number, shot in enumerate(job["shots"]):
        motion = Motion.load(shot["motion"])
        apply_motion(character.armature, motion, 1, scene=scene, mapping=character.mapping)
        scene.frame_start, scene.frame_end = 1, int((len(motion.directions) - 1) / motion.fps * job["fps"]) + 1
        _aim(scene, place, *CAMERAS[shot["camera"]])
        settings.display.shading.studio_light, settings.view_settings.exposure = LIGHTS[shot["light"]]
        share = lambda done, number=number: voice.progress("film", (number + done) / len(job["shots"]))  # noqa: E731
        render.film(scene, shot["output"], render.Look(), share)
    return {"outputs": [shot["output"] for shot in job["shots"]]}


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
