"""Gestures of a take as pose markers, and what an animator makes of them: other takes that differ where they were edited."""

import bpy
import numpy as np
import pytest
from acted import curves, press
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.takes import directing, takes


@pytest.fixture
def take(speaker, examples):
    """A mannequin with a take of the shipped recording, keyed on every frame."""
    speaker.s2ag.audio, speaker.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    return takes.active(speaker).action


def now(armature):
    return takes.active(armature).action


def differing(one, other):
    """Frames at which keys of two actions differ."""
    first, second = curves(one), curves(other)
    assert first.keys() == second.keys()
    return sorted({frame for key in first for frame in first[key][(first[key] != second[key]).any(1), 0]})


def middle(action):
    found = directing.shown(action, bpy.context.scene)
    return found[len(found) // 2]


def test_gestures_are_marked_and_moved_by_their_markers(speaker, take):
    scene, one = bpy.context.scene, middle(take)
    assert {marker.name for marker in take.pose_markers} == {one.name for one in directing.shown(take, scene)}
    with pytest.raises(RuntimeError, match="All markers are where they were"):
        press(bpy.ops.s2ag.apply_markers)
    take.pose_markers[one.name].frame += 8
    assert press(bpy.ops.s2ag.apply_markers) == {"FINISHED"}
    after = now(speaker)
    (edit,) = provenance.of(after)["edits"]
    assert edit["do"] == "move" and len(speaker.s2ag.takes) == 2
    fps = scene.render.fps
    assert any(abs(other.at - edit["to"]) <= 0.08 for other in directing.shown(after, scene))
    frames = np.array(differing(take, after))
    assert len(frames) and np.abs(frames - one.frame).max() < 3 * fps


def test_edits_are_kept_and_added_to(speaker, take, tmp_path):
    scene = bpy.context.scene
    scene.frame_set(middle(take).frame)
    assert press(bpy.ops.s2ag.change_gesture, size=0.7) == {"FINISHED"}
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    name = now(speaker).name
    assert [edit["do"] for edit in provenance.of(now(speaker))["edits"]] == ["change", "delete"]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "directed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "directed.blend"))
    action = bpy.data.actions[name]
    assert [edit["do"] for edit in directing.made(action)] == ["change", "delete"]
    assert len(action.pose_markers) == len(directing.shown(action, bpy.context.scene))


def test_a_range_is_made_anew_with_the_next_seed_each_time(speaker, take):
    scene = bpy.context.scene
    with pytest.raises(RuntimeError, match="No preview range"):
        press(bpy.ops.s2ag.reroll_range)
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 100, 160
    for seed in (1, 2):
        assert press(bpy.ops.s2ag.reroll_range) == {"FINISHED"}
        (edit,) = directing.made(now(speaker))
        assert edit["seed"] == seed
        frames = differing(take, now(speaker))
        assert frames[0] >= 95 and frames[-1] <= 166  # two frames of the motion around it


def test_a_gesture_is_added_at_the_playhead(speaker, take):
    scene = bpy.context.scene
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.add_gesture, kind="big") == {"FINISHED"}
    one = directing.nearest(now(speaker), scene)
    assert one.kind == "big" and abs(one.frame - 180) <= 2


def test_takes_of_before_are_told_apart(speaker, take):
    del take[directing.GESTURES]
    assert directing.shown(take, bpy.context.scene) == [] and not bpy.ops.s2ag.delete_gesture.poll()
    take[directing.GESTURES] = '[[1, 2], "x", [1.0, "left", "beat", 0.3, "so"]]'
    assert len(directing.shown(take, bpy.context.scene)) == 1


def test_gestures_lie_where_they_are_made_whatever_the_speed(speaker, take):
    """Strokes become quicker between turns that stay, so their moments move by less than a stroke, a third of a second."""
    speaker.s2ag.speed = 1.5
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    scene = bpy.context.scene
    slow, quick = directing.shown(take, scene), directing.shown(now(speaker), scene)
    assert [one.frame for one in slow] == [one.frame for one in quick]
    assert quick[-1].frame > 0.9 * take.frame_range[1]
