"""The headless job, run as users run it: in a process of its own, heard through its standard output."""

import json
import os
import signal
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest
from s2ag.core.errors import UsageError
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.render import job as jobs
from s2ag.s2ag_blender.render import opengl

needs_opengl = pytest.mark.skipif(not opengl.is_available(), reason="this machine offers no OpenGL, not even in software")


@pytest.fixture
def write(tmp_path, wave):
    """A function that writes a job, half a second of waving for the mannequin changed by its arguments."""
    motion = tmp_path / "motion.npz"

    def make(frames=8, **content):
        wave(frames).save(motion)
        whole = {"motions": [str(motion)], "character": "mannequin", "resolution": [96, 72], **content}
        (tmp_path / "job.json").write_text(json.dumps(whole))
        return tmp_path / "job.json"

    return make


def run(path, **environment):
    """Exit status and the events of a job; every line of its standard output must be one."""
    command = [sys.executable, "-m", "s2ag.s2ag_blender.render.job", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | environment)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]


@needs_opengl
def test_one_job_makes_every_kind_of_file(write, tmp_path, examples):
    out = tmp_path / "out"
    out.mkdir()
    outputs = [str(out / f"take{suffix}") for suffix in (".mp4", ".png", ".blend", ".bvh", ".fbx", ".glb")]
    status, events = run(write(outputs=outputs, audio=str(examples / "hello.flac"), fps=15))
    *progress, result = events
    assert status == 0 and result["event"] == "result", result
    assert result["frames"] == [1, 8] and result["fps"] == 15
    assert sorted(path.name for path in out.iterdir()) == sorted(os.path.basename(path) for path in outputs)
    film = (out / "take.mp4").read_bytes()
    assert b"avc1" in film and b"mp4a" in film
    assert (out / "take.png").read_bytes().startswith(b"\x89PNG")
    shares = [event["value"] for event in progress if event["stage"] == "write take.mp4"]
    assert shares == sorted(shares) and shares[0] == 0 and shares[-1] == 1 and len(shares) >= 8


def test_what_the_scene_reads_is_no_output(tmp_path):
    image = bpy.data.images.new("wall", 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / "wall.png"), "PNG"
    image.save()
    with pytest.raises(UsageError, match="read by the scene"):
        jobs._spare_inputs([tmp_path / "other.mp4", tmp_path / "." / "wall.png"])
    jobs._spare_inputs([tmp_path / "other.mp4"])


@pytest.mark.slow
def test_a_users_scene_keeps_its_range_and_rate(write, tmp_path):
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 30, 5, 10
    mannequin.build()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mine.blend"))
    out = tmp_path / "out.blend"
    status, events = run(write(character=str(tmp_path / "mine.blend"), outputs=[str(out)], start_frame=3))
    assert status == 0, events
    bpy.ops.wm.open_mainfile(filepath=str(out))
    scene = bpy.context.scene
    assert scene.render.fps == 30 and scene.frame_start == 5
    assert scene.frame_end == events[-1]["frames"][1] == 3 + 14  # seven steps at 15 frames a second
    assert scene.camera is not None


@pytest.mark.slow
def test_several_characters_are_named(write, tmp_path):
    for name in ("Ann", "Bob"):
        mannequin.build().armature.name = name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    job = {"character": str(tmp_path / "two.blend"), "outputs": [str(tmp_path / "out.bvh")]}
    status, events = run(write(**job))
    assert status == 2 and "Ann" in events[-1]["message"] and "Bob" in events[-1]["message"]
    status, events = run(write(**job, armature="Bob"))
    assert status == 0 and (tmp_path / "out.bvh").is_file(), events
    status, events = run(write(**job, armature="Eve"))
    assert status == 2 and events[-1]["kind"] == "RigUnusable" and "Ann" in events[-1]["remedy"]


def test_a_character_without_arms_is_refused(write, tmp_path):
    item = bpy.data.objects.new("Stick", bpy.data.armatures.new("Stick"))
    bpy.context.scene.collection.objects.link(item)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "stick.blend"))
    status, events = run(write(character=str(tmp_path / "stick.blend"), outputs=[str(tmp_path / "out.bvh")]))
    assert status == 2 and events[-1]["kind"] == "RigUnusable" and events[-1]["remedy"]
    assert not (tmp_path / "out.bvh").exists()


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"character": "dragon"}, "RigUnusable"),
        ({"character": "absent.glb"}, "RigUnusable"),
        ({"character": "human:centaur"}, "RigUnusable"),
        ({"motions": ["absent.npz"]}, "MotionUnreadable"),
        ({"motions": []}, "UsageError"),
        ({"audio": "absent.wav"}, "AudioUnreadable"),
        ({"outputs": ["absent/take.bvh"]}, "OutputUnwritable"),
        ({"outputs": ["take.png"], "engine": "povray"}, "UsageError"),
        ({"colour": "blue"}, "UsageError"),
    ],
)
def test_bad_jobs_end_with_one_error_and_no_file(write, tmp_path, change, kind):
    path = write(**{"outputs": [str(tmp_path / "take.bvh")], **change})
    before = set(tmp_path.iterdir())
    status, events = run(path)
    assert status == 2
    assert events[-1]["event"] == "error" and events[-1]["message"]
    assert events[-1]["kind"] == kind or change.get("character") == "human:centaur"
    assert set(tmp_path.iterdir()) == before


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the switch that hides OpenGL is one of Linux")
def test_without_opengl_the_remedy_is_told(write, tmp_path):
    job = write(outputs=[str(tmp_path / "take.mp4")])
    status, events = run(job, __EGL_VENDOR_LIBRARY_DIRS=str(tmp_path))
    assert status == 2 and events[-1]["kind"] == "BlenderUnavailable" and "cycles" in events[-1]["remedy"]


@needs_opengl
@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM")
def test_a_stopped_job_leaves_nothing(write, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    job = write(frames=900, outputs=[str(out / "take.mp4")])
    command = [sys.executable, "-m", "s2ag.s2ag_blender.render.job", str(job)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        for line in process.stdout:
            event = json.loads(line)
            if event["stage"] == "write take.mp4" and event["value"] > 0:
                break
        assert list(out.iterdir())
        process.send_signal(signal.SIGTERM)
        process.wait(30)
        time.sleep(0.1)
    assert not list(out.iterdir())


@pytest.mark.parametrize("name", ["Female_Adult_01.fbx", "Male_Adult_01.fbx"])
def test_a_stock_character_gestures(write, shared, tmp_path, name):
    path = shared / "rocketbox" / name
    if not path.is_file():
        pytest.skip(f"{name} is absent")
    status, events = run(write(character=str(path), outputs=[str(tmp_path / "take.glb")]))
    assert status == 0 and (tmp_path / "take.glb").stat().st_size > 10_000, events


def test_the_still_shows_the_raised_hand(wave):
    motion = wave(61)
    row = jobs.expressive_frame(motion)
    height = -motion.directions[:, 5, 1]
    assert height[row] > np.quantile(height, 0.8)
    assert jobs.expressive_frame(Motion(motion.directions[:1])) == 0
