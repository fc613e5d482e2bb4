"""The render and encode stages in a real Blender: one process for many clips, images that survive a kill, scenes of several."""

import json
import os
import signal
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest
from load import resident_of_children
from s2ag.core.batch import clip, encode, folder, process_pool, stages
from s2ag.core.cli import blender
from s2ag.core.errors import OutputUnwritable
from s2ag.s2ag_blender import program
from s2ag.s2ag_blender.characters import loading, mannequin
from s2ag.s2ag_blender.render import job as jobs
from s2ag.s2ag_blender.render import opengl, render, serve

needs_opengl = pytest.mark.skipif(not opengl.is_available(), reason="this machine offers no OpenGL, not even in software")


@pytest.fixture
def batch(tmp_path, wave, examples):
    """A function that makes a batch whose gestures are there already: half a second of waving a clip."""

    def make(*rows, frames=8):
        place = folder.Folder(tmp_path / "out")
        common = {"audio": str(examples / "hello.flac"), "resolution": (64, 48), "fps": 15}
        clips = [clip.Clip(line, **{"name": f"c{line}", **common, **row}) for line, row in enumerate(rows, 1)]
        whole = stages.Batch(place, clips)
        for step, one in zip(whole.steps("synth", whole.units), clips, strict=True):
            paths = stages.motion_paths(place, one)
            for path in paths:
                path.parent.mkdir(parents=True, exist_ok=True)
                wave(frames).save(path)
            facts = {"motions": [folder.digest(path) for path in paths], "recording": "r", "duration": 0.5, "warnings": []}
            step.record.write(step.key, paths, facts)
        return whole

    return make


def perform(whole, stage, jobs=1):
    """Run a stage as the command line does; the errors of what failed, by name."""
    if stage == "encode":
        pytest.importorskip("av", reason="the engine is not installed")
    command = blender.command("render.serve") if stage == "render" else [sys.executable, "-m", "s2ag.core.batch.tasks"]
    return {step.name: error for step, error in stages.run_stage(whole, stage, whole.units, command, jobs)}


def probe(path):
    av = pytest.importorskip("av", reason="the engine is not installed")
    with av.open(str(path)) as film:
        count = sum(1 for _ in film.decode(video=0))
        return film.streams.video[0], film.streams.audio[0] if film.streams.audio else None, count, film.duration / 1e6


@needs_opengl
def test_every_output_lands_and_a_second_run_does_nothing(batch, tmp_path):
    kinds = ("rig-bvh", "fbx", "glb", "usd", "blend", "png", "mp4")
    whole = batch({"outputs": kinds, "takes": 2})
    assert perform(whole, "render") == {"c1-1": None, "c1-2": None}
    for kind in kinds[:-1]:
        suffix = {**clip.CHARACTER_OUTPUTS, **clip.SCENE_OUTPUTS}[kind]
        found = sorted(path.name for path in (tmp_path / "out" / kind).iterdir())
        assert found == [f"c1-1{suffix}", f"c1-2{suffix}"]
    assert perform(whole, "render") == {} and perform(whole, "encode") == {"c1-1": None, "c1-2": None}
    stages.delete_leftovers(whole, whole.units)
    assert not list((tmp_path / "out" / ".work").iterdir()) and not list((tmp_path / "out" / ".part").iterdir())
    assert perform(whole, "render") == perform(whole, "encode") == {}
    video, sound, count, seconds = probe(tmp_path / "out" / "mp4" / "c1-2.mp4")
    assert (video.width, video.height, count) == (64, 48, 8) and sound is not None and seconds < 0.8
    os.remove(tmp_path / "out" / "mp4" / "c1-2.mp4")
    assert set(perform(whole, "render")) == {"c1-2"} and set(perform(whole, "encode")) == {"c1-2"}


@needs_opengl
def test_usd_holds_skeleton_and_motion(batch, tmp_path):
    whole = batch({"outputs": ("usd",)})
    assert perform(whole, "render") == {"c1": None}
    bpy.ops.wm.usd_import(filepath=str(tmp_path / "out" / "usd" / "c1.usd"))
    (armature,) = [item for item in bpy.context.scene.objects if item.type == "ARMATURE"]
    scene, turns = bpy.context.scene, []
    for frame in (1, 3, 5, 7):
        scene.frame_set(frame)
        forearm = next(bone for bone in armature.pose.bones if bone.name.replace("_", ".").startswith("lower.arm.L"))
        turns.append(np.array(forearm.matrix.to_quaternion()))
    assert np.ptp(turns, axis=0).max() > 0.05


@pytest.mark.slow
@needs_opengl
def test_images_of_a_killed_process_are_kept(batch, tmp_path):
    whole = batch({"outputs": ("mp4",), "resolution": (640, 360)}, frames=60)
    (step,) = whole.steps("render", whole.units)
    request = {"id": 0, "method": "render", "params": step.task.params}
    process = subprocess.Popen(
        blender.command("render.serve"), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.flush()
    images = whole.folder.work("c1", "mp4", step.key)
    deadline = time.monotonic() + 120
    while len(list(images.glob("*.png"))) < 5 and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    kept = {path.name: path.stat().st_mtime_ns for path in images.glob("*.png")}
    assert 5 <= len(kept) < 60
    assert perform(whole, "render") == {"c1": None}
    now = {path.name: path.stat().st_mtime_ns for path in images.glob("*.png")}
    assert sorted(now) == [f"{frame:06d}.png" for frame in range(1, 61)]
    assert all(now[name] == written for name, written in kept.items())


@needs_opengl
def test_a_bad_character_fails_alone_and_blender_stays(batch, tmp_path):
    (tmp_path / "bad.blend").write_bytes(b"BLENDER but no more")
    rows = [{"outputs": ("fbx",)}, {"outputs": ("fbx",), "character": str(tmp_path / "bad.blend")}, {"outputs": ("fbx",)}]
    whole = batch(*rows)
    found = perform(whole, "render")
    assert found["c1"] is None and found["c3"] is None and found["c2"].kind == "RigUnusable"
    assert whole.steps("render", whole.units)[1].state == "failed"


@pytest.mark.slow
@needs_opengl
def test_sequences_land_as_folders_with_and_without_background(batch, tmp_path):
    looks = [{"outputs": ("frames", "mp4"), "preset": "transparent", "engine": "workbench"}, {"outputs": ("exr",)}]
    whole = batch(*looks, frames=4)
    assert set(perform(whole, "render").values()) == {None}
    frames = sorted((tmp_path / "out" / "frames" / "c1").iterdir())
    assert [path.name for path in frames] == [f"{frame:06d}.png" for frame in range(1, 5)]
    picture = bpy.data.images.load(str(frames[0]))
    alpha = np.array(picture.pixels[:]).reshape(-1, 4)[:, 3]
    assert picture.channels == 4 and alpha.min() == 0 and alpha.max() == 1
    exr = bpy.data.images.load(str(sorted((tmp_path / "out" / "exr" / "c2").iterdir())[0]))
    assert exr.is_float and tuple(exr.size) == (64, 48)
    assert perform(whole, "encode") == {"c1": None}
    assert probe(tmp_path / "out" / "mp4" / "c1.mp4")[2] == 4


@pytest.mark.slow
@needs_opengl
def test_frames_are_counted_from_where_the_row_says(batch, tmp_path):
    whole = batch({"outputs": ("frames", "mp4"), "start_frame": 1001}, frames=3)
    assert perform(whole, "render") == perform(whole, "encode") == {"c1": None}
    assert min(path.name for path in (tmp_path / "out" / "frames" / "c1").iterdir()) == "001001.png"
    assert probe(tmp_path / "out" / "mp4" / "c1.mp4")[2] == 3


@pytest.mark.slow
def test_a_bone_map_is_used_and_another_one_makes_the_clip_anew(batch, tmp_path):
    from s2ag.rigs import maps
    from s2ag.s2ag_blender.rig import reading

    armature = mannequin.build().armature
    maps.save(tmp_path / "map.json", reading.resolve_mapping(armature, reading.read(armature), None))
    whole = batch({"outputs": ("rig-bvh",), "map": str(tmp_path / "map.json")})
    assert perform(whole, "render") == {"c1": None} and perform(whole, "render") == {}
    mapped = json.loads((tmp_path / "map.json").read_text())
    (tmp_path / "map.json").write_text(json.dumps(mapped | {"left_forearm": [], "left_upper_arm": []}))
    assert perform(whole, "render")["c1"].kind == "RigUnusable"


@needs_opengl
def test_images_that_another_program_takes_away_are_missed(tmp_path, wave):
    wave(4).save(tmp_path / "motion.npz")
    content = {"motions": [str(tmp_path / "motion.npz")], "character": "mannequin", "resolution": [64, 48], "fps": 15}
    job = jobs.Job.of({**content, "outputs": [str(tmp_path / "shot.###.png")]})

    def tell(text):
        if (tmp_path / "shot.003.png").exists():
            (tmp_path / "shot.001.png").unlink(missing_ok=True)

    with pytest.raises(OutputUnwritable, match="1 of 4 images"):
        jobs.perform(job, program.EventWriter(tell))


@pytest.mark.slow
def test_finals_need_no_opengl(batch, tmp_path):
    whole = batch({"outputs": ("exr",), "preset": "film", "engine": "cycles"}, frames=2)
    assert perform(whole, "render") == {"c1": None}
    assert len(list((tmp_path / "out" / "exr" / "c1").iterdir())) == 2


@pytest.mark.slow
@needs_opengl
def test_several_characters_share_a_scene_and_speak_in_turn(batch, tmp_path):
    talk = {"scene": "talk", "resolution": (96, 54)}
    whole = batch({**talk, "outputs": ("mp4", "fbx")}, {**talk, "outputs": ("fbx", "blend"), "delay": 1.0})
    assert perform(whole, "render") == {"talk": None} and perform(whole, "encode") == {"talk": None}
    assert sorted(path.name for path in (tmp_path / "out" / "fbx").iterdir()) == ["c1.fbx", "c2.fbx"]
    _, sound, count, seconds = probe(tmp_path / "out" / "mp4" / "talk.mp4")
    assert count == 8 + 15 and sound is not None and abs(seconds - count / 15) < 0.2
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "blend" / "talk.blend"))
    armatures = [item for item in bpy.context.scene.objects if item.type == "ARMATURE"]
    assert len(armatures) == 2 and abs(armatures[0].location.x - armatures[1].location.x) == pytest.approx(loading.SPACING)
    starts = sorted(item.animation_data.action.frame_start for item in armatures)
    assert starts == [1, 16]


@pytest.mark.slow
@needs_opengl
def test_a_users_scene_keeps_its_camera_light_and_size(batch, tmp_path):
    scene = bpy.context.scene
    for name, x in (("Ann", -0.6), ("Bob", 0.6)):
        armature = mannequin.build().armature
        armature.name, armature.location.x = name, x
    camera = bpy.data.objects.new("Mine", bpy.data.cameras.new("Mine"))
    camera.location = (0, -4, 1.2)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera, scene.world = camera, bpy.data.worlds.new("Mine")
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "BLENDER_WORKBENCH", 160, 120
    scene.render.resolution_percentage, scene.frame_step = 50, 3
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mine.blend"))
    common = {"scene": "duet", "character": str(tmp_path / "mine.blend"), "resolution": None, "fps": None}
    whole = batch({**common, "armature": "Ann", "outputs": ("mp4", "blend")}, {**common, "armature": "Bob", "outputs": ()})
    assert perform(whole, "render") == {"duet": None} and perform(whole, "encode") == {"duet": None}
    video = probe(tmp_path / "out" / "mp4" / "duet.mp4")[0]
    assert (video.width, video.height, video.average_rate) == (80, 60, 24)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "blend" / "duet.blend"))
    assert bpy.context.scene.camera.name == "Mine" and len(bpy.data.cameras) == 1
    assert bpy.context.scene.render.resolution_percentage == 50 and bpy.context.scene.frame_step == 3
    assert all(bpy.data.objects[name].animation_data.action for name in ("Ann", "Bob"))
    assert [round(bpy.data.objects[name].location.x, 2) for name in ("Ann", "Bob")] == [-0.6, 0.6]


@pytest.mark.slow
@needs_opengl
def test_a_preview_of_a_scene_for_another_engine_shows_its_textures(batch, tmp_path):
    material = mannequin.build().meshes[0].data.materials[0]
    picture = bpy.data.images.new("red", 8, 8)
    picture.generated_color = (1, 0, 0, 1)
    picture.pack()
    if not material.node_tree:
        material.use_nodes = True
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = picture
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    material.node_tree.nodes.active = texture
    for item in bpy.context.scene.objects:
        if item.type == "MESH" and not item.data.uv_layers:
            item.data.uv_layers.new()
    bpy.context.scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "red.blend"))
    whole = batch({"outputs": ("png", "blend"), "character": str(tmp_path / "red.blend"), "preset": "preview"})
    assert perform(whole, "render") == {"c1": None}
    seen = np.array(bpy.data.images.load(str(tmp_path / "out" / "png" / "c1.png")).pixels[:]).reshape(-1, 4)
    assert (seen[:, 0] > 2 * seen[:, 1]).mean() > 0.02
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out" / "blend" / "c1.blend"))
    assert bpy.context.scene.render.engine == "CYCLES" and bpy.context.scene.display.shading.color_type == "MATERIAL"


@pytest.mark.slow
@needs_opengl
def test_many_clips_do_not_grow_blender(batch):
    """The second half of a hundred exports needs no more memory than the first."""
    if not sys.platform.startswith("linux"):
        pytest.skip("reads /proc")
    whole = batch({"outputs": ("fbx",)})
    (step,) = whole.steps("render", whole.units)
    sizes = []
    running = process_pool.ProcessPool(blender.command("render.serve"), 1).run(
        [process_pool.Task("render", step.task.params, n) for n in range(60)]
    )
    for task, outcome, _ in running:
        if isinstance(outcome, dict) and task.label in (19, 59):
            sizes.append(resident_of_children())
    assert len(sizes) == 2 and sizes[1] < 1.15 * sizes[0]


@needs_opengl
def test_numbered_images_by_a_job(tmp_path, wave):
    wave(4).save(tmp_path / "motion.npz")
    content = {"motions": [str(tmp_path / "motion.npz")], "character": "mannequin", "resolution": [64, 48], "fps": 15}
    pattern = tmp_path / "shot.###.png"
    jobs.perform(jobs.Job.of({**content, "outputs": [str(pattern)]}), program.EventWriter(lambda text: None))
    assert sorted(path.name for path in tmp_path.glob("shot*")) == [f"shot.{frame:03d}.png" for frame in range(1, 5)]
    assert not list(tmp_path.glob(".part*"))


def test_runs_and_names_of_frames(tmp_path):
    assert render._runs([1, 2, 3, 7, 9, 10]) == [(1, 3), (7, 7), (9, 10)] and render._runs([]) == []
    assert render._runs(list(range(1, 51))) == [(1, 24), (25, 48), (49, 50)]
    assert render.numbered(tmp_path / "a.####.exr", 12).name == "a.0012.exr"
    assert encode.PATTERN.replace("%06d", "#" * 6) == serve.FRAMES + ".png"
