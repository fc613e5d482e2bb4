"""A take follows its sound strip, and is directed on from there."""

import bpy
import numpy as np
import pytest
from acted import curves, drawn, press
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.takes import directing, retiming, takes
from s2ag.s2ag_blender.ui import gesture_panel as ui

pytestmark = pytest.mark.usefixtures("sound_system")


@pytest.fixture
def take(speaker, examples):
    speaker.s2ag.audio, speaker.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    return takes.active(speaker).action


def now(armature):
    return takes.active(armature).action


def moved_by(found, by):
    return {key: keys + np.array([by, 0], keys.dtype) for key, keys in found.items()}


@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
def test_a_take_follows_its_strip_with_all_its_versions(speaker, take, result):
    scene = bpy.context.scene
    if result != "ACTION":
        speaker.s2ag.result = result
        press(bpy.ops.s2ag.generate)
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    assert not bpy.ops.s2ag.follow_sound.poll() and "s2ag.follow_sound" not in drawn(ui.S2AG_PT_directing)
    before = [curves(action) for action in takes_actions(speaker)]
    gestures = [(one.at, one.frame) for one in directing.shown(now(speaker), scene)]
    strip = retiming.strip_of(now(speaker), scene)
    compat.move_strip(strip, compat.strip_start(strip) + 48)
    assert "s2ag.follow_sound" in drawn(ui.S2AG_PT_directing)
    bpy.ops.ed.undo_push(message="moved")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    for old, action in zip(before, takes_actions(speaker), strict=True):
        there = moved_by(old, 48)
        assert all(np.array_equal(keys, there[key]) for key, keys in curves(action).items())
        assert provenance.of(action)["place"]["first"] == round(provenance.of(action)["start"])
    assert [(one.at, one.frame - 48) for one in directing.shown(now(speaker), scene)] == gestures
    assert not bpy.ops.s2ag.follow_sound.poll()
    scene.frame_set(228)
    moved = now(speaker)
    assert press(bpy.ops.s2ag.add_gesture, kind="big") == {"FINISHED"}
    one = next(one for one in directing.shown(now(speaker), scene) if one.kind == "big" and abs(one.frame - 228) <= 2)
    far = [keys[keys[:, 0] > one.frame + 90] for keys in curves(now(speaker)).values()]
    former = [keys[keys[:, 0] > one.frame + 90] for keys in curves(moved).values()]
    assert all(np.array_equal(*pair) for pair in zip(far, former, strict=True)) and len(compat.sound_strips(scene)) == 1


def takes_actions(armature):
    from s2ag.s2ag_blender.takes import versions

    return versions.actions(takes.active(armature))


def test_a_move_is_one_step_back(speaker, take):
    scene, before = bpy.context.scene, curves(take)
    strip = retiming.strip_of(take, scene)
    compat.move_strip(strip, compat.strip_start(strip) + 10)
    bpy.ops.ed.undo_push(message="moved")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    bpy.ops.ed.undo()
    again = curves(now(bpy.data.objects["Mannequin"]))
    assert all(np.array_equal(keys, again[key]) for key, keys in before.items())


def test_other_animation_is_not_moved(speaker, take, tmp_path):
    from acted import animate

    own = animate(speaker, ["spine"] if "spine" in speaker.pose.bones else [speaker.pose.bones[0].name])
    press(bpy.ops.s2ag.generate)
    before, scene = curves(own), bpy.context.scene
    strip = retiming.strip_of(now(speaker), scene)
    compat.move_strip(strip, compat.strip_start(strip) + 10)
    with pytest.raises(RuntimeError, match="other animation"):
        press(bpy.ops.s2ag.follow_sound)
    assert all(np.array_equal(keys, before[key]) for key, keys in curves(own).items())
