"""What animators expect of such an extension, each driven as a user would: one test for every row of the list."""

import json
import os
import tomllib
from pathlib import Path

import bpy
import numpy as np
import pytest
from acted import animate, apart, curves, drawn, overridden, pose, press, same_curves, settle
from s2ag.core.motion import rest, skeleton
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.keys import apply, layers, poses
from s2ag.s2ag_blender.rig import readiness, reading
from s2ag.s2ag_blender.takes import engine_requests, generate, markers, menu_items, session, take_list

ROOT = Path(__file__).resolve().parents[3]


def engine_pid():
    return engine_requests.engine(bpy.context).pid


def counts(armature):
    data = armature.animation_data
    return len(bpy.data.actions), len(data.nla_tracks) if data else 0, len(bpy.context.scene.timeline_markers)


def test_one_undo_step_nothing_changed_on_cancel(speaker):
    speaker.s2ag.result, speaker.s2ag.add_markers, speaker.s2ag.take_count = "LAYER", True, 2
    speaker.s2ag.transcript_source, speaker.s2ag.typed = "TYPED", "hello there"
    before = counts(speaker)
    bpy.ops.ed.undo_push(message="ready")
    press(bpy.ops.s2ag.generate)
    assert counts(speaker) != before
    bpy.ops.ed.undo()
    speaker = bpy.data.objects["Mannequin"]
    assert counts(speaker) == before and not speaker.s2ag.takes
    run = session.Run(bpy.context, speaker, generate.plan(bpy.context, speaker))
    bpy.ops.s2ag.cancel()
    with pytest.raises(Exception, match="Cancelled"):
        run.step()
    run.end()
    assert counts(speaker) == before and not speaker.s2ag.takes


@pytest.mark.parametrize("result", ["ACTION", "STRIP", "LAYER"])
def test_non_destructive(speaker, result):
    walk = animate(speaker, [bone.name for bone in speaker.data.bones], frames=(1, 20, 90))
    before, length = curves(walk), tuple(walk.frame_range)
    speaker.s2ag.result = result
    press(bpy.ops.s2ag.generate)
    assert same_curves(walk, before) and tuple(walk.frame_range) == length and provenance.read(walk) is None
    assert walk.users > 0 and speaker.s2ag.takes[0].action != walk


@pytest.mark.parametrize("span", ["SCENE", "PREVIEW", "OWN", "STRIP"])
def test_only_the_chosen_range(speaker, span, request):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 20, 50
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 30, 45
    speaker.s2ag.range, speaker.s2ag.start_frame = span, 12
    first, last = {"SCENE": (20, 50), "PREVIEW": (30, 45), "OWN": (12, 12 + 71), "STRIP": (15, 40)}[span]
    if span == "STRIP":
        request.getfixturevalue("sound_system")
        strip = compat.sequencer_strips(scene.sequence_editor_create()).new_sound("voice", speaker.s2ag.audio, 1, 10)
        strip.frame_offset_start, strip.frame_final_end = 5, 41
    press(bpy.ops.s2ag.generate)
    found = np.concatenate(list(curves(speaker.animation_data.action).values()))[:, 0]
    assert (found.min(), found.max()) == (first, pytest.approx(last, abs=2 if span == "OWN" else 0))


@pytest.mark.parametrize("result", ["ACTION", "STRIP", "LAYER"])
def test_blend_in_out_with_what_is_there(speaker, result):
    arm = reading.resolve_mapping(speaker, reading.read(speaker)).chains["left_upper_arm"][0]
    animate(speaker, [arm], frames=(1, 120), turn=1.5)
    first, last = pose(speaker, 10), pose(speaker, 82)
    speaker.s2ag.result, speaker.s2ag.start_frame = result, 10
    press(bpy.ops.s2ag.generate)
    end = layers.Place.of(speaker.s2ag.takes[0].action).last
    assert apart({arm: first[arm]}, {arm: pose(speaker, 10)[arm]}) < 0.5
    assert apart({arm: last[arm]}, {arm: pose(speaker, end)[arm]}) < 3  # a frame or so apart in time


def test_intensity_speed_smoothing(speaker):
    def spread(intensity):
        speaker.s2ag.intensity = intensity
        press(bpy.ops.s2ag.generate)
        found = curves(speaker.animation_data.action)
        return sum(column[:, 1].std() for column in found.values())

    still, half, full = spread(0.0), spread(0.5), spread(1.0)
    assert still < 0.02 * full and still < half < full
    speaker.s2ag.curves, speaker.s2ag.key_step = "FRAMES", 4  # keys far apart, with smooth curves between
    press(bpy.ops.s2ag.generate)
    keys = curves(speaker.animation_data.action)
    assert all((np.diff(column[:, 0]) == 4).all() for column in keys.values())
    assert {"rate", "speed", "smoothing"} <= set(speaker.s2ag.bl_rna.properties.keys())  # how often gestures come, and how


def test_hand_choice_mirror(speaker, random_checkpoint):
    speaker.s2ag.start_pose = "REST"
    planned = generate.plan(bpy.context, speaker)
    plain = engine_requests.call(bpy.context, planned.params)["motions"][0]
    mirrored = engine_requests.call(bpy.context, {**planned.params, "mirror": True})["motions"][0]
    np.testing.assert_allclose(mirrored.mirrored().directions, plain.directions, atol=1e-5)
    speaker.s2ag.hand, speaker.s2ag.mirror, speaker.s2ag.checkpoint = 1.0, True, str(random_checkpoint)
    press(bpy.ops.s2ag.generate)
    told = provenance.read(speaker.animation_data.action)
    assert told["hand"] == 1.0 and told["mirror"]


def test_lock_bones_parts(speaker):
    mapping = reading.resolve_mapping(speaker, reading.read(speaker)).chains
    speaker.s2ag.parts = {"HEAD", "RIGHT_ARM"}
    (neck, *_), (clavicle, *_) = mapping["neck"], mapping["right_clavicle"]
    speaker.pose.bones[neck].lock_rotation = (True, True, True)
    press(bpy.ops.s2ag.generate)
    keyed = {path.split('"')[1] for path, _ in curves(speaker.animation_data.action)}
    (hand,) = mapping["right_hand"]
    fingers = {bone.name for bone in speaker.pose.bones[hand].children_recursive}
    assert keyed == {*mapping["head"], *mapping["right_upper_arm"], *mapping["right_forearm"], hand} | fingers
    assert clavicle not in keyed


def test_seed_another_take_keep_history(speaker):
    press(bpy.ops.s2ag.generate)
    press(bpy.ops.s2ag.generate)
    first, same = (take.action for take in speaker.s2ag.takes)
    assert same_curves(first, same)
    press(bpy.ops.s2ag.reroll)
    assert len(speaker.s2ag.takes) == 3 and not same_curves(first, speaker.animation_data.action)
    press(bpy.ops.s2ag.recall_take)
    assert speaker.s2ag.seed == provenance.read(speaker.animation_data.action)["seed"] != 0


def test_a_slider_brings_a_draft(speaker, examples):
    speaker.s2ag.audio = str(examples / "hello.flac")  # 14.7 seconds
    speaker.s2ag.range, bpy.context.scene.frame_end = "SCENE", 240
    window = bpy.context.window_manager.s2ag
    window.live = True

    settle()
    drafted = pose(speaker, 100)
    speaker.s2ag.intensity = 0.3
    settle()
    assert apart(drafted, pose(speaker, 100)) > 1
    window.live = False


def test_audio_in_the_sequencer_in_sync(speaker, sound_system):
    speaker.s2ag.start_frame = 33
    press(bpy.ops.s2ag.generate)
    (strip,) = compat.sound_strips(bpy.context.scene)
    assert compat.strip_start(strip) == 33 == speaker.animation_data.action.frame_range[0]
    assert bpy.context.scene.sync_mode == "AUDIO_SYNC"


def test_a_strip_of_the_sequencer_and_its_mixdown_as_voice(speaker, sound_system):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 20, 70
    strip = compat.sequencer_strips(scene.sequence_editor_create()).new_sound("line", speaker.s2ag.audio, 1, 25)
    speaker.s2ag.audio, speaker.s2ag.audio_source = "", "STRIP"
    press(bpy.ops.s2ag.generate)
    assert speaker.animation_data.action.frame_range[0] == 25
    speaker.s2ag.audio_source, speaker.s2ag.range = "MIXDOWN", "SCENE"
    press(bpy.ops.s2ag.generate)
    place = layers.Place.of(speaker.animation_data.action)
    assert (place.first, place.last) == (20, 70)
    assert len(compat.sound_strips(scene)) == 1 and compat.strip_start(strip) == 25


def test_words_as_markers(figure, engine, examples):
    figure.s2ag.audio, figure.s2ag.add_markers = str(examples / "hello.flac"), True
    words = (examples / "hello.txt").read_text().split()
    scene = bpy.context.scene
    scene.timeline_markers.new("mine", frame=5)
    press(bpy.ops.s2ag.generate)
    assert len(markers.ours(scene, "w:")) == len(words)
    press(bpy.ops.s2ag.remove_markers)
    assert [marker.name for marker in scene.timeline_markers] == ["mine"] and not bpy.ops.s2ag.remove_markers.poll()


@pytest.mark.parametrize("suffix", [".bvh", ".glb", ".fbx"])
def test_bvh_fbx_glb_out(speaker, tmp_path, suffix):
    press(bpy.ops.s2ag.generate)
    arm = reading.resolve_mapping(speaker, reading.read(speaker)).chains["left_upper_arm"][0]
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 72
    name, path = speaker.name, str(tmp_path / f"out{suffix}")
    now = pose(speaker, 30)
    assert bpy.ops.s2ag.export(filepath=path, format=suffix) == {"FINISHED"} and os.path.getsize(path) > 1000
    if suffix != ".bvh":
        return
    bpy.ops.import_anim.bvh(filepath=path, rotate_mode="NATIVE", axis_forward="Y", axis_up="Z")
    imported = bpy.context.active_object
    assert imported.name != name
    there = pose(imported, 30)

    def along(poses, scale):
        hand = reading.resolve_mapping(speaker, reading.read(speaker)).chains["left_forearm"][0]
        way = poses[hand][:3, 3] - poses[arm][:3, 3]
        return way / np.linalg.norm(way) * scale

    assert np.degrees(np.arccos(np.clip(along(now, 1) @ along(there, 1), -1, 1))) < 0.5


def test_presets(figure):
    figure.s2ag.style, figure.s2ag.intensity = "stern", 0.4
    assert bpy.ops.s2ag.preset_add(name="Expected") == {"FINISHED"}
    figure.s2ag.style, figure.s2ag.intensity = "", 1.0
    path = bpy.utils.preset_find("Expected", "s2ag/character")
    bpy.ops.script.execute_preset(filepath=path, menu_idname="S2AG_PT_presets")
    assert figure.s2ag.style == "stern" and figure.s2ag.intensity == pytest.approx(0.4)


def test_bone_map_auto_and_readable_state(figure):
    readiness.clear_cache()
    readiness.schedule(figure)  # as drawing does where there is a window
    readiness.update_pending()
    ready, shown = readiness.cached(figure), drawn()
    assert not ready.problem and ready.found == 9
    assert "9 of 9 parts" in shown and all(readiness.label(row.part) in shown for row in ready.rows)


def test_linked_override_rigs(speaker, tmp_path):
    override = overridden(speaker, tmp_path)
    bpy.ops.object.mode_set(mode="POSE")
    override.s2ag.intensity = 0.9
    for result in ("ACTION", "LAYER"):
        override.s2ag.result = result
        assert bpy.ops.s2ag.generate() == {"FINISHED"}
    assert override.mode == "POSE" and override.animation_data.nla_tracks[0].strips[0].action.library is None
    assert override.override_library.reference.animation_data is None


def test_progress_and_cancel(speaker, examples, tmp_path):
    unheard = tmp_path / "unheard.flac"
    unheard.write_bytes((examples / "hello.flac").read_bytes())
    speaker.s2ag.audio, speaker.s2ag.take_count = str(unheard), 16
    engine_requests.engine(bpy.context).call("hello", {"warm": True})
    pid, run = engine_pid(), session.Run(bpy.context, speaker, generate.plan(bpy.context, speaker))
    while run.stage != "generate":
        assert run.step() is None
    assert "Making the gestures: 16 takes" in drawn() and "s2ag.cancel" in drawn()
    bpy.ops.s2ag.cancel()
    assert "Cancelling" in drawn()
    with pytest.raises(Exception, match="Cancelled"):
        run.step()
    run.end()
    assert engine_requests.engine(bpy.context).call("hello") and engine_pid() == pid


def test_useful_errors(speaker, tmp_path):
    noise = tmp_path / "noise.wav"
    noise.write_bytes(b"not a sound")
    speaker.s2ag.audio = str(noise)
    with pytest.raises(RuntimeError) as error:
        bpy.ops.s2ag.generate()
    (line,) = str(error.value).strip().splitlines()
    assert "noise.wav" in line and "Traceback" not in line
    shown = [text for text, _ in session.messages(speaker)]
    assert len(shown) == 2 and all(line in drawn() for text in shown for line in menu_items.wrap_text(text))


def test_offline():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    network = manifest["permissions"].get("network", "")
    assert not network or "set" in network.lower()  # only the button that sets the engine up; the engine itself never
    sources = [path for folder in ("s2ag_blender", "core", "rigs") for path in (ROOT / folder).rglob("*.py")]
    words = ("import socket", "import urllib", "from urllib", "import requests", "import http")
    assert not [path.name for path in sources if any(word in path.read_text("utf-8") for word in words)]


def test_zero_surprise_units_scale(speaker):
    speaker.scale, speaker.rotation_euler.z, speaker.location.y = (0.01, 0.01, 0.01), 1.0, 3.0
    bpy.context.view_layer.update()
    before = [np.array(bone.matrix_local) for bone in speaker.data.bones]
    modes, world = [bone.rotation_mode for bone in speaker.pose.bones], np.array(speaker.matrix_world)
    for result in ("ACTION", "STRIP", "LAYER"):
        speaker.s2ag.result = result
        press(bpy.ops.s2ag.generate)
    assert all(np.array_equal(was, np.array(bone.matrix_local)) for was, bone in zip(before, speaker.data.bones, strict=True))
    assert modes == [bone.rotation_mode for bone in speaker.pose.bones]
    assert np.array_equal(world, np.array(speaker.matrix_world))
    paths = {path for take in speaker.s2ag.takes for path, _ in curves(take.action) if "rotation" not in path}
    assert paths <= {'pose.bones["hips"].location'}  # where the weight goes from foot to foot


def test_every_greyed_button_says_why(figure, monkeypatch):
    """Each operator that cannot run now refuses with a sentence of its own, not with Blender's."""
    refused = {}
    for name in ("cancel", "generate", "reroll", "vary", "style_grid", "keep_take", "delete_take", "delete_others"):
        operator = getattr(bpy.ops.s2ag, name)
        if operator.poll():
            continue
        with pytest.raises(RuntimeError) as error:
            operator()
        refused[name] = str(error.value)
    assert len(refused) == 8 and not [name for name, text in refused.items() if "context is incorrect" in text], refused


def test_provenance_tells_how_to_make_it_again(speaker):
    press(bpy.ops.s2ag.generate)
    told = provenance.read(speaker.animation_data.action)
    assert {"audio", "style", "seed", "take", "checkpoint", "version", "place", "settings"} <= set(told)
    assert json.dumps(told) and take_list.remake_arguments(speaker.animation_data.action)["seed"] == told["seed"]


def test_a_seed_pose_comes_back_from_a_posed_character(figure):
    motion = Motion(np.repeat(skeleton.normalize(rest.REST)[None], 4, 0))
    apply.apply_motion(figure, motion, start_frame=1)
    bpy.context.scene.frame_set(2)
    bones = reading.read(figure)
    found = poses.directions(figure, bones, reading.resolve_mapping(figure, bones))
    assert np.degrees(np.arccos(np.clip((found * rest.REST).sum(-1), -1, 1))).max() < 1.5
