"""Bodies that wait, listen, sit, hold something and speak lines, by the command line and the Blender that is tested."""

import json
import shutil

import bpy
import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.characters import mannequin

pytestmark = pytest.mark.slow

TABLE = 1.3


def run(*arguments):
    assert main([str(argument) for argument in arguments]) == 0


def opened(path):
    """The armature of a saved scene, and its action."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    return armature, armature.animation_data.action


def keyed_bones(action):
    return {curve.data_path.split('"')[1] for curve in compat.curves(action) if curve.data_path.startswith("pose.bones")}


def wrists(armature, frames):
    rows = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        rows.append([armature.pose.bones[name].head[:] for name in ("hand.L", "hand.R")])
    return np.array(rows)


def test_who_waits_lays_the_hands_on_a_table_or_lets_them_hang(tmp_path):
    run("idle", "--seconds", 3, "--seed", 4, "--loop", "-o", tmp_path / "idle.npz")
    found = {}
    for seated in ("off", "on", str(TABLE)):
        out = tmp_path / f"waits-{seated}.blend"
        run("animate", tmp_path / "idle.npz", "--character", "mannequin", "--seated", seated, "-o", out)
        armature, action = opened(out)
        first, last = map(int, action.frame_range)
        assert last - first == 3 * bpy.context.scene.render.fps and provenance.read(action)["loops"]
        found[seated] = wrists(armature, [first, (first + last) // 2, last])
        assert np.abs(found[seated][0] - found[seated][-1]).max() < 1e-3  # a loop
        if seated != "off":
            assert not [name for name in keyed_bones(action) if name.split(".")[0] in ("hips", "thigh", "shin", "foot")]
    hanging, lap, table = (found[seated] for seated in found)
    assert table[..., 2].min() > TABLE > lap[..., 2].max() > hanging[..., 2].max() + 0.05
    assert lap[..., 1].max() < hanging[..., 1].min() - 0.05  # ahead


def test_who_listens_on_a_chair_moves_and_has_the_hands_on_the_lap(voice, tmp_path):
    run("synth", voice, "--no-transcript", "--listen", "-o", tmp_path / "listens.npz")
    run("animate", tmp_path / "listens.npz", "--character", "mannequin", "--seated", "on", "-o", tmp_path / "a.blend")
    armature, action = opened(tmp_path / "a.blend")
    assert provenance.read(action)["listen"]
    first, last = map(int, action.frame_range)
    heads = []
    for frame in range(first, last):
        bpy.context.scene.frame_set(frame)
        heads.append([*armature.pose.bones["head"].tail])
    assert np.ptp(heads, axis=0).max() > 1e-3
    both = wrists(armature, range(first, last, 8))
    assert both[..., 1].max() < -0.1 and both[..., 2].max() < TABLE


def test_an_arm_that_is_locked_stays_and_the_other_one_talks(voice, tmp_path):
    figure, busy = mannequin.build().armature, ("upper_arm.L", "lower_arm.L", "hand.L")
    for name in busy:
        figure.pose.bones[name].lock_rotation = (True, True, True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cup.blend"))
    run("synth", voice, "--no-transcript", "--hand", "right", "-o", tmp_path / "talks.npz")
    run("animate", tmp_path / "talks.npz", "--character", tmp_path / "cup.blend", "-o", tmp_path / "talks.blend")
    _, action = opened(tmp_path / "talks.blend")
    assert provenance.read(action)["hand"] == 1.0
    assert not keyed_bones(action) & set(busy) and keyed_bones(action) >= {"upper_arm.R", "lower_arm.R", "hand.R"}


def test_a_folder_of_recordings_is_one_file_for_a_game(voice, tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in ("hello", "goodbye"):
        shutil.copy(voice, folder / f"{name}.wav")
    out = tmp_path / "lines.glb"
    run("lines", folder, "--character", "mannequin", "--fps", 24, "--idle", 2, "-o", out)
    told = json.loads(out.with_suffix(".json").read_text("utf-8"))
    assert told["fps"] == 24 and told["root"] == "hips" and set(told["lines"]) == {"hello", "goodbye", "idle"}
    assert [name for name, line in told["lines"].items() if line["loop"]] == ["idle"]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24
    bpy.ops.import_scene.gltf(filepath=str(out))
    for name, line in told["lines"].items():
        (action,) = [one for one in bpy.data.actions if name in one.name]
        first, last = action.frame_range
        assert abs(last - first + 1 - line["frames"]) < 0.01, name
