"""Lines for games, read back: an action a line by its name, at the rate asked for, that begins and ends in one pose."""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest
from s2ag.core.cli import lines as verb
from s2ag.core.motion import rest
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis import idling
from s2ag.s2ag_blender import compat, program
from s2ag.s2ag_blender.render import lines

pytestmark = pytest.mark.slow

FPS = 30


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    """Twenty short lines: waving arms from everywhere, settled, and one idle."""
    folder, paths = tmp_path_factory.mktemp("lines"), {}
    for number in range(19):
        moving = idling.idle(1.0 + 0.02 * number, seed=number, stillness=0.0)
        paths[f"line_{number:02d}"] = verb.settled(moving)
    paths["idle"] = replace(idling.idle(2.0, loop=True, fps=FPS), pelvis=None)
    for name, motion in paths.items():
        motion.save(folder / f"{name}.npz")
    return {name: str(folder / f"{name}.npz") for name in paths}


def write(motions, output, each=None):
    about = {"character": "mannequin", "gender": "female", "armature": None, "maps": [None, None], "fps": FPS}
    told = []
    result = lines.perform({**about, "lines": motions, "output": str(output), "each": each}, program.EventWriter(told.append))
    assert result["root"] == "hips"
    return result


def read_back(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = FPS
    if path.suffix == ".fbx":
        bpy.ops.import_scene.fbx(filepath=str(path))
    else:
        bpy.ops.import_scene.gltf(filepath=str(path))
    assert not [item for item in bpy.data.objects if item.type == "MESH" and item.parent is not None]
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    return armature


def poses(armature, action, frames):
    slots = getattr(action, "slots", None)
    armature.animation_data_create()
    compat.assign_action(armature, action, slots[0] if slots else None)
    for track in armature.animation_data.nla_tracks:
        track.mute = True
    rows = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame))
        rows.append([value for name in ("hand.L", "hand.R", "head") for value in armature.pose.bones[name].head])
    root = np.array(armature.matrix_world @ armature.pose.bones["hips"].matrix)
    return np.array(rows), root


@pytest.mark.parametrize("suffix", [".fbx", ".glb"])
def test_twenty_lines_come_back_from_one_file(motions, tmp_path, suffix):
    write(motions, tmp_path / f"lines{suffix}")
    armature = read_back(tmp_path / f"lines{suffix}")
    ends, roots = [], []
    for name, path in motions.items():
        (action,) = [one for one in bpy.data.actions if name in one.name]
        first, last = action.frame_range
        motion = Motion.load(path)
        assert abs((last - first) - (len(motion.directions) - 1) * FPS / motion.fps) <= 1.01
        placed, root = poses(armature, action, [first, last])
        assert np.abs(placed[0] - placed[1]).max() < 2e-3 * armature.pose.bones["head"].head.length
        ends += [placed[0]] if name != "idle" else []
        roots.append(root)
    assert np.ptp(ends, axis=0).max() < 2e-3 * armature.pose.bones["head"].head.length
    assert np.ptp(roots, axis=0).max() < 1e-4 * max(np.abs(roots).max(), 1)


@pytest.mark.parametrize("kind", verb.EACH)
def test_a_file_for_each_line(motions, tmp_path, kind):
    few = {name: motions[name] for name in ("line_03", "idle")}
    write(few, tmp_path, kind)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"{name}.{kind}" for name in few)
    if kind in ("fbx", "glb"):
        armature = read_back(tmp_path / f"line_03.{kind}")
        action = armature.animation_data.action or armature.animation_data.nla_tracks[0].strips[0].action
        assert "line_03" in action.name


def test_a_line_leaves_and_reaches_rest():
    moving = idling.idle(3.0, seed=2, stillness=0.0)
    line = verb.settled(moving)
    assert line.pelvis is None and np.allclose(line.directions[[0, -1]], rest.REST, atol=1e-5)
    middle = slice(10, -10)
    assert np.allclose(line.directions[middle], moving.directions[middle], atol=1e-5)
    assert line.face.weights[0].max() == line.face.weights[-1].max() == 0


def test_what_a_game_is_told():
    about = json.loads(json.dumps(verb.describe(idling.idle(4.0, loop=True), FPS)))
    assert about["loop"] and about["frames"] == 4 * FPS + 1 and about["seconds"] == 4.0
    assert all(one["begin"] <= one["stroke"] <= one["hold"] <= one["end"] for one in about["events"])
