"""What a take leaves when another comes: no frozen poses, names that belong together, warnings, the scene's end."""

import bpy
import numpy as np
import pytest
from acted import drawn, pose, press
from s2ag.s2ag_blender.keys import layers
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import take_list


def bones_of(armature, *parts):
    chains = reading.resolve_mapping(armature, reading.read(armature)).chains
    return [bone for part in parts for bone in chains[part]]


def turned(armature, bones, frame=40):
    """Degrees by which bones are turned from rest, at most."""
    pose(armature, frame)
    angles = [armature.pose.bones[name].matrix_basis.to_quaternion().angle for name in bones]
    return max(np.degrees(min(angle, 2 * np.pi - angle)) for angle in angles)


@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
def test_parts_that_are_no_longer_gestured_do_not_freeze(speaker, result):
    speaker.s2ag.result = result
    body, arms = bones_of(speaker, "torso", "neck", "head"), bones_of(speaker, "left_upper_arm", "right_upper_arm")
    bpy.context.scene.frame_set(40)
    press(bpy.ops.s2ag.generate)
    assert turned(speaker, body) > 0.5 and turned(speaker, arms) > 5
    speaker.s2ag.parts = {"LEFT_ARM", "RIGHT_ARM"}
    press(bpy.ops.s2ag.generate)
    assert turned(speaker, body) < 0.01 and turned(speaker, arms) > 5
    speaker.s2ag.active_take = 0
    assert turned(speaker, body) > 0.5
    speaker.s2ag.active_take = 1
    assert turned(speaker, body) < 0.01
    take_list.delete(speaker, [1, 0])
    assert turned(speaker, arms) < 0.01


def test_a_pose_that_the_user_gave_a_part_comes_back(speaker):
    (head, *_) = bones_of(speaker, "head")
    speaker.pose.bones[head].rotation_mode = "XYZ"
    speaker.pose.bones[head].rotation_euler.x = 0.5
    press(bpy.ops.s2ag.generate)
    pose(speaker, 40)
    speaker.s2ag.parts = {"LEFT_ARM", "RIGHT_ARM"}
    press(bpy.ops.s2ag.generate)
    pose(speaker, 40)
    assert tuple(speaker.pose.bones[head].rotation_euler) == pytest.approx((0.5, 0, 0))


def test_names_link_take_action_and_strip(speaker):
    speaker.name, speaker.s2ag.style, speaker.s2ag.result = "Marcus", "calm lecturer", "STRIP"
    for _ in range(2):
        press(bpy.ops.s2ag.generate)
    assert [take.title for take in speaker.s2ag.takes] == ["calm lecturer 1", "calm lecturer 2"]
    (strip,) = layers.strips(speaker)
    assert strip.name == strip.action.name == speaker.s2ag.takes[1].action.name == "Marcus – voice – calm lecturer 2"
    speaker.s2ag.takes[1].title = "the one"
    assert strip.name == strip.action.name == "Marcus – voice – the one"
    press(bpy.ops.s2ag.generate)  # the number is free again
    assert speaker.s2ag.takes[2].title == "calm lecturer 2"


def test_warnings_stay_with_their_take_when_the_file_is_opened_again(speaker, tmp_path):
    speaker.s2ag.add_markers, speaker.s2ag.transcript_source = True, "NONE"
    speaker.s2ag.add_sound = False  # which not every build of Blender can play
    press(bpy.ops.s2ag.generate)
    warning = "There are no word markers, because the words are not known."
    assert speaker.s2ag.takes[0].warnings == warning
    speaker.s2ag.add_markers = False
    press(bpy.ops.s2ag.generate)
    assert not speaker.s2ag.takes[1].warnings
    speaker.s2ag.active_take = 0
    path, name = str(tmp_path / "scene.blend"), speaker.name
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.view_layer.objects.active = bpy.data.objects[name]
    shown = " ".join(drawn())
    assert "There are no word markers" in shown and "voice.wav from frame 1" in shown


def test_the_scene_is_offered_to_end_where_the_gestures_do(speaker, tmp_path, capfd):
    scene = bpy.context.scene
    speaker.s2ag.start_frame = scene.frame_start = 11
    scene.frame_end, scene.render.fps, scene.render.fps_base = 40, 30, 1.001
    press(bpy.ops.s2ag.generate)
    ends = [(frame - 10) / (30 / 1.001) for frame in (speaker.s2ag.takes[0].last, 40)]
    shown = " ".join(drawn())
    assert f"Gestures until {ends[0]:.1f} s, scene ends at {ends[1]:.1f} s" in shown and "s2ag.fit_range" in shown
    assert ends == pytest.approx([3.0, 1.0], abs=0.1)
    scene.frame_start, scene.frame_end = 1, 24
    bpy.ops.s2ag.export(filepath=str(tmp_path / "cut.bvh"), format=".bvh")
    assert "Cut where the scene ends" in "".join(capfd.readouterr())
    press(bpy.ops.s2ag.fit_range)
    assert scene.frame_start == 1 and scene.frame_end == speaker.s2ag.takes[0].last > 70
    assert "s2ag.fit_range" not in drawn() and "Exports the frames of the scene" in drawn()
    bpy.ops.s2ag.export(filepath=str(tmp_path / "whole.bvh"), format=".bvh")
    assert "Cut where" not in "".join(capfd.readouterr())
    frames = [int((tmp_path / f"{name}.bvh").read_text().split("Frames: ")[1].split()[0]) for name in ("cut", "whole")]
    assert frames == [24, scene.frame_end]


def test_a_hidden_character_is_still_the_chosen_one(speaker):
    shown = bones_of(speaker, "left_upper_arm")
    speaker.hide_set(True)
    assert bpy.ops.s2ag.generate.poll() and press(bpy.ops.s2ag.generate) == {"FINISHED"}
    assert speaker.hide_get() and speaker.s2ag.takes[0].action and "s2ag.generate" in drawn()
    speaker.hide_set(False)
    assert turned(speaker, shown) > 5
