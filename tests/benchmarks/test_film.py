"""Seconds to build the human, and a frame of film at the size that `s2ag animate` takes by default."""

import pytest

bpy = pytest.importorskip("bpy")

from s2ag.core.errors import S2agError  # noqa: E402
from s2ag.s2ag_blender.characters import human  # noqa: E402
from s2ag.s2ag_blender.render import render, stage  # noqa: E402

FRAMES = 24


@pytest.fixture
def person():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    try:
        return human.build()
    except S2agError as error:
        pytest.skip(str(error))


def test_build(benchmark, person):
    benchmark.pedantic(human.build, rounds=3)


def test_film(benchmark, person, tmp_path):
    scene = bpy.context.scene
    stage.set_up_scene(scene, [person])
    scene.frame_start, scene.frame_end = 1, FRAMES
    benchmark.pedantic(render.film, args=(scene, tmp_path / "film.mp4"), rounds=2, warmup_rounds=1)
    benchmark.extra_info["seconds_a_frame"] = a_frame = benchmark.stats.stats.mean / FRAMES
    print(f"\n{scene.render.resolution_x}x{scene.render.resolution_y}, Workbench: {a_frame:.2f} s a frame")
