"""How long Blender's own thread is held: every step of a run, timed one by one as the modal operator takes them.

A step is what happens between two moments at which Blender may draw and hear its user. Seconds are those of the thread's
processor, so that a busy machine does not count.
"""

import time

import numpy as np
import pytest
from sounds import RATE, write_wav

bpy = pytest.importorskip("bpy")
pytest.importorskip("pytest_benchmark")

import s2ag  # noqa: E402
from s2ag.s2ag_blender.takes import engine_requests, generate, menu_items, session  # noqa: E402

HELD = 0.1
"""Seconds that no step may take."""


@pytest.fixture(params=["mannequin", "human"])
def figure(request):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s2ag.register()
    armature = engine_requests.add_character(request.param)
    bpy.context.view_layer.objects.active = armature
    yield armature
    engine_requests.stop_engine()
    s2ag.unregister()


@pytest.fixture
def minute(examples, tmp_path):
    """A minute of the shipped recording, again and again, as WAV."""
    from s2ag.core.sound import audio

    sound = audio.load(examples / "hello.flac")
    write_wav(tmp_path / "minute.wav", np.tile(sound, 5)[: 60 * RATE])
    return tmp_path / "minute.wav"


def steps(armature, **changes) -> dict[str, list[float]]:
    """Seconds of every step of a run, by what it was at."""
    taken: dict[str, list[float]] = {}

    def step(name, work):
        began = time.thread_time()
        done = work()
        taken.setdefault(name, []).append(time.thread_time() - began)
        return done

    planned = step("plan", lambda: generate.plan(bpy.context, armature, **changes))
    run = step("ask", lambda: session.Run(bpy.context, armature, planned))
    outcome = None
    while outcome is None:
        laying = run._laying is not None
        outcome = step("lay" if laying else "listen", run.step)
        time.sleep(0.0 if laying else 0.02)
    run.end()
    assert len(outcome.actions) == len(armature.s2ag.takes)
    return taken


def test_generate_and_24_takes_hold_blender_briefly(benchmark, figure, minute):
    figure.s2ag.audio, figure.s2ag.curves = str(minute), "POSES"
    styles = menu_items.style_names()[:24]
    taken = benchmark.pedantic(steps, (figure,), {"styles": styles}, rounds=1)
    told = {name: round(1000 * max(values)) for name, values in taken.items()}
    benchmark.extra_info["longest_ms"] = told
    print(f"\n{figure.name}, {len(styles)} takes of a minute, {len(taken['lay'])} slices; longest, ms:", told)
    assert max(max(values) for values in taken.values()) < HELD
