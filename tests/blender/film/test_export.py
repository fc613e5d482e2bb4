"""Files of a gesturing character: the right bones, the right frames, and nothing else."""

import json
import struct

import bpy
import handed
import numpy as np
import pytest
from bodies import performance
from s2ag.core.errors import OutputUnwritable, UsageError
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.cast import mannequin
from s2ag.s2ag_blender.film import export
from s2ag.s2ag_blender.film.sound import add_sound
from s2ag.s2ag_blender.keys.apply import apply_motion


@pytest.fixture
def character(wave):
    """A mannequin that gestures from frame 1 to 16 beside a cube."""
    scene = bpy.context.scene
    scene.render.fps = 15
    scene.frame_start, scene.frame_end = 1, 16
    scene.collection.objects.link(bpy.data.objects.new("Bystander", bpy.data.meshes.new("Bystander")))
    character = mannequin.build()
    apply_motion(character.armature, wave(16), 1)
    return character


def test_bvh_has_the_frames_and_the_bones(character, tmp_path):
    export.export(bpy.context.scene, character, tmp_path / "take.bvh")
    text = (tmp_path / "take.bvh").read_text()
    assert "Frames: 16" in text and "Frame Time: 0.066667" in text
    assert {"hips", "upper_arm.L", "hand.R"} <= {
        line.split()[1] for line in text.splitlines() if "JOINT" in line or "ROOT" in line
    }


def test_glb_holds_one_animation_of_the_right_length(character, tmp_path):
    export.export(bpy.context.scene, character, tmp_path / "take.glb")
    content = (tmp_path / "take.glb").read_bytes()
    length = struct.unpack("<I", content[12:16])[0]
    scene = json.loads(content[20 : 20 + length])
    (animation,) = scene["animations"]
    times = scene["accessors"][animation["samplers"][0]["input"]]
    assert times["min"][0] == 0 and times["max"][0] == pytest.approx(1.0, abs=1e-3)
    names = {node.get("name") for node in scene["nodes"]}
    assert "upper_arm.L" in names and "Bystander" not in names


def test_fbx_comes_back_with_the_gesture(character, tmp_path):
    export.export(bpy.context.scene, character, tmp_path / "take.fbx")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(tmp_path / "take.fbx"))
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    assert "upper_arm.L" in armature.data.bones and "Bystander" not in bpy.data.objects
    (action,) = bpy.data.actions
    start, end = action.frame_range
    assert end - start == pytest.approx(15, abs=0.01)
    assert any("lower_arm.L" in curve.data_path for curve in compat.curves(action))


def test_blend_takes_the_recording_along(character, tmp_path, examples):
    scene = bpy.context.scene
    sound = add_sound(scene, examples / "hello.flac", 1).sound
    before = sound.filepath
    with export.portable(sound, tmp_path):
        export.export(scene, character, tmp_path / "take.blend")
    assert sound.filepath == before
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "take.blend"))
    assert bpy.data.objects["Mannequin"].animation_data.action is not None
    (kept,) = bpy.data.sounds
    assert kept.packed_file and kept.filepath.startswith("//")


def test_selection_is_given_back(character, tmp_path):
    bystander = bpy.data.objects["Bystander"]
    bystander.select_set(True)
    bpy.context.view_layer.objects.active = bystander
    character.meshes[0].hide_set(True)
    export.export(bpy.context.scene, character, tmp_path / "take.fbx")
    assert bystander.select_get() and bpy.context.view_layer.objects.active is bystander
    assert not character.armature.select_get() and character.meshes[0].hide_get()


def test_nothing_is_left_where_writing_fails(character, tmp_path):
    with pytest.raises(UsageError, match=".glb"):
        export.export(bpy.context.scene, character, tmp_path / "take.abc")
    with pytest.raises(OutputUnwritable):
        export.export(bpy.context.scene, character, tmp_path / "absent" / "take.fbx")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".fbx", ".glb"])
def test_feet_stay_and_fingers_move_in_files(tmp_path, suffix):
    scene, directions = bpy.context.scene, performance(16)
    scene.render.fps = 15
    scene.frame_start, scene.frame_end = 1, 16
    character = mannequin.build()
    motion = Motion(directions, hands=handed.hands(directions), pelvis=handed.pelvis(16))
    apply_motion(character.armature, motion, 1)
    export.export(scene, character, tmp_path / f"take{suffix}")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 15
    importer = bpy.ops.import_scene.fbx if suffix == ".fbx" else bpy.ops.import_scene.gltf
    importer(filepath=str(tmp_path / f"take{suffix}"))
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    seen = {name: [] for name in ("foot.L", "foot.R", "hips", "index_1.L", "index_2.L")}
    for frame in range(0, 18):
        bpy.context.scene.frame_set(frame)
        for name, places in seen.items():
            places.append(armature.matrix_world @ armature.pose.bones[name].matrix)
    feet = [np.array(seen[name])[:, :3, 3] for name in ("foot.L", "foot.R")]
    assert max(np.abs(places - places[0]).max() for places in feet) < 0.005
    assert np.ptp(np.array(seen["hips"])[:, 0, 3]) > 0.03
    bends = [(a.inverted() @ b).to_quaternion() for a, b in zip(seen["index_1.L"], seen["index_2.L"], strict=True)]
    assert max(np.degrees(bends[1].rotation_difference(bend).angle) for bend in bends[1:-1]) > 3
