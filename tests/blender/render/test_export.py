"""Files of a gesturing character: the right bones, the right frames, and nothing else."""

import json
import re
import struct

import bpy
import handed
import numpy as np
import pytest
import rigging
from bodies import performance
from s2ag.core.errors import OutputUnwritable, UsageError
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import human, mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.render import export
from s2ag.s2ag_blender.render.sound import add_sound
from s2ag.s2ag_blender.takes import engine_requests

pytestmark = pytest.mark.slow


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


def test_files_and_their_animations_are_called_after_what_is_played(character, tmp_path):
    scene, armature = bpy.context.scene, character.armature
    name, before = "Ann: – calm/lecturer 2", scene.name
    armature.animation_data.action.name = name
    assert engine_requests.file_name(armature) == "Ann  - calm lecturer 2"
    armature.animation_data.action.name = "Zoë – Straße"
    assert engine_requests.file_name(armature) == "Zoe - Strasse"
    armature.animation_data.action.name = "声"
    assert engine_requests.file_name(armature) == "gestures"
    armature.animation_data.action.name = name
    for suffix in (".glb", ".fbx"):
        export.export(scene, character, tmp_path / f"take{suffix}")
        written = (tmp_path / f"take{suffix}").read_bytes()
        assert name.encode() in written or json.dumps(name).encode() in written
    assert scene.name == before
    armature.animation_data_clear()
    assert export.animation_name(armature) == armature.name


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
    with export.portable_sound(sound, tmp_path):
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


IMPORTERS = {
    ".fbx": bpy.ops.import_scene.fbx,
    ".glb": bpy.ops.import_scene.gltf,
    ".usdc": bpy.ops.wm.usd_import,
}


def shown(item, frames) -> list[dict]:
    """World places of all bones' heads ``{bone: (3,)}`` at scene frames, spelt as USD does."""
    found = []
    for frame in frames:
        heads = {re.sub(r"\W", "_", name): pose[:, 3] for name, pose in rigging.evaluated(item, frame).items()}
        found.append({name: (np.array(item.matrix_world) @ at)[:3] for name, at in heads.items()})
    return found


@pytest.mark.parametrize("build", [mannequin.build, human.build], ids=["mannequin", "human"])
@pytest.mark.parametrize("suffix", IMPORTERS)
def test_fingers_pelvis_and_all_else_come_back_from_files(tmp_path, suffix, build):
    scene, directions = bpy.context.scene, performance(16)
    scene.render.fps = 15
    scene.frame_start, scene.frame_end = 1, 16
    character = build()
    motion = Motion(directions, hands=handed.hands(directions), pelvis=handed.pelvis(16))
    apply_motion(character.armature, motion, 1)
    before = shown(character.armature, range(1, 17))
    moved = {name: np.ptp([heads[name] for heads in before], axis=0).max() for name in before[0]}
    assert sum(size > 0.03 for size in moved.values()) > 30  # hips, trunk, arms, and thumbs and fingers of both hands
    export.export(scene, character, tmp_path / f"take{suffix}")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 15
    IMPORTERS[suffix](filepath=str(tmp_path / f"take{suffix}"))
    (item,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    first = round(bpy.data.actions[0].frame_range[0])
    after = shown(item, range(first, first + 16))
    assert before[0].keys() <= after[0].keys()
    far = {name: max(np.linalg.norm(a[name] - b[name]) for a, b in zip(before, after, strict=True)) for name in before[0]}
    assert max(far.values()) < 1e-3, max(far, key=far.get)
