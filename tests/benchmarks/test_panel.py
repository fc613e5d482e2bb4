"""What the extension costs a Blender in which nobody uses it: drawing its panels, and starting up.

Blender has no layout to draw on without a window, so panels are drawn on a stand-in whose calls cost about what the real
ones' Python side does (a call, the look-up of the property, a note); what is measured is the extension's own work.
"""

import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("pytest_benchmark")

import s2ag  # noqa: E402
from acted import drawn, settle  # noqa: E402
from s2ag.s2ag_blender.rig import readiness  # noqa: E402
from s2ag.s2ag_blender.takes import take_list  # noqa: E402
from s2ag.s2ag_blender.ui import handlers  # noqa: E402

HELLO = Path(s2ag.__file__).parent / "examples" / "hello.flac"
DRAW, REGISTER = 0.002, 0.100
"""Seconds that all panels, and registering, may cost; of the processor's time, so that a busy machine does not count."""


@pytest.fixture
def figure(request):
    """A mannequin, or who is asked for, with twenty takes, layers and words: every panel is full."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s2ag.register()
    getattr(bpy.ops.s2ag, getattr(request, "param", "add_mannequin"))()
    armature = bpy.context.active_object
    for number in range(20):
        take = armature.s2ag.takes.add()
        take.name, take.title, take.action = f"1.{number}", f"Take {number}", bpy.data.actions.new("take")
    armature.s2ag.active_take, armature.s2ag.result = 3, "LAYER"
    armature.s2ag.style_second = "tired"
    armature.s2ag.audio = "/voice.wav"
    readiness.readiness_of(armature)
    assert take_list.active(armature)
    yield armature
    s2ag.unregister()


@pytest.mark.parametrize("figure", ["add_mannequin", "add_human"], indirect=True)
def test_draw_all_panels(benchmark, figure):
    """The human has a face, whose shape keys are looked up."""
    benchmark.pedantic(drawn, rounds=200, warmup_rounds=10)
    best, median = benchmark.stats.stats.min, benchmark.stats.stats.median
    print(f"\nall panels: {best * 1000:.2f} ms at best, {median * 1000:.2f} ms median")
    assert best < DRAW


def test_register(benchmark, tmp_path):
    """In a fresh Blender each time, with all that registering imports; the first one compiles it, too, as after installing."""
    code = textwrap.dedent("""
        import sys, time, bpy
        import s2ag
        began = time.process_time()
        s2ag.register()
        print(time.process_time() - began)
        assert not {"torch", "librosa", "gensim"} & set(sys.modules)
    """)
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    kept["PYTHONPYCACHEPREFIX"] = str(tmp_path)

    def once():
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=kept)
        found.append(float(next(line for line in done.stdout.splitlines() if line.replace(".", "").isdigit())))

    found = []
    once()
    benchmark.pedantic(once, rounds=5)
    first, *later = found
    print(f"\nregister: {first * 1000:.0f} ms the first time, then {sorted(later)[2] * 1000:.0f} ms (median of 5)")
    assert min(later) < REGISTER


def test_draft(benchmark, figure):
    """A slider's draft of ten seconds of speech, beside the whole take with a warm engine."""
    figure.s2ag.audio, figure.s2ag.range = str(HELLO), "SCENE"
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 240
    began = time.perf_counter()
    assert bpy.ops.s2ag.generate() == {"FINISHED"}  # libraries are loaded, the recording is heard
    first = time.perf_counter() - began
    bpy.context.window_manager.s2ag.live = True
    settle()

    def drag():
        figure.s2ag.intensity = 0.9 if figure.s2ag.intensity < 0.8 else 0.6
        settle()

    benchmark.pedantic(drag, rounds=5, warmup_rounds=1)
    bpy.context.window_manager.s2ag.live = False
    began = time.perf_counter()
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    whole, draft = time.perf_counter() - began, benchmark.stats.stats.median
    print(f"\ndraft: {draft:.2f} s; the take itself {whole:.2f} s, the first one {first:.2f} s")
    assert draft < 1.5 * whole


def test_what_watching_costs(benchmark, figure):
    """After each change of the scene a handler only notes it; the look itself waits until Blender is idle."""
    depsgraph, scene = bpy.context.evaluated_depsgraph_get(), bpy.context.scene

    def look():
        readiness.note_change()
        readiness.readiness_of(figure)

    began = time.perf_counter()
    for _ in range(20):
        look()
    looked = (time.perf_counter() - began) / 20
    benchmark(handlers._after_update, scene, depsgraph)
    noted = benchmark.stats.stats.median
    print(f"\nhandler {noted * 1e6:.1f} microseconds, a look {looked * 1e6:.0f}")
    assert noted < 0.1 * looked
