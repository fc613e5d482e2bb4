"""Feelings from here, rests and points among the kinds, errors that leave, and keys on what can vary alone."""

import bpy
import numpy as np
import pytest
from acted import apart, curves, now, pose, press, same_curves
from mathutils import Quaternion
from s2ag.s2ag_blender.takes import decisions, gesture_edits, menu_items, session, take_list
from s2ag.s2ag_blender.ui import decisions as panel


def test_a_feeling_begins_at_the_playhead_and_is_a_decision_that_can_be_changed(speaker, take):
    bpy.context.scene.frame_set(90)
    at = gesture_edits.seconds_at(take, bpy.context.scene, 90)
    assert press(bpy.ops.s2ag.feeling_from, mood="excited", strength=0.5) == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert edit == {"do": "feel", "at": pytest.approx(at, abs=1e-3), "arousal": 0.5}
    words = decisions.words_of(edit, now(speaker), menu_items.gesture_label)
    assert words.startswith("Excited 0.5 from ")
    assert press(bpy.ops.s2ag.change_decision, number=0, arousal=-0.4, valence=0.0, dominance=0.0) == {"FINISHED"}
    assert gesture_edits.edits_of(now(speaker))[0]["arousal"] == pytest.approx(-0.4)
    assert "feel" in panel._CHANGEABLE


def test_keys_set_by_hand_stay_where_a_later_change_of_feeling_touches_nothing(speaker, take):
    """Also those in the span of an earlier edit, and those of properties that no gesture keys."""
    scene = bpy.context.scene
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 20, 80
    assert press(bpy.ops.s2ag.rest_range, what="PREVIEW") == {"FINISHED"}
    bone = next(one for one in speaker.pose.bones if "arm" in one.name.lower())
    scene.frame_set(50)
    bone.rotation_quaternion = bone.rotation_quaternion @ Quaternion((1, 0, 0), 0.3)
    for path in ("rotation_quaternion", "location"):
        bone.keyframe_insert(path, frame=50)
    before = curves(now(speaker))
    scene.frame_set(240)
    assert press(bpy.ops.s2ag.feeling_from, mood="excited") == {"FINISHED"}
    after = curves(now(speaker))
    assert before.keys() == after.keys() and not same_curves(before, now(speaker))
    early = {key: [points[points[:, 0] < 200] for points in (before[key], after[key])] for key in before}
    assert all(np.array_equal(old, new) for old, new in early.values())


@pytest.mark.slow
def test_a_style_or_feeling_that_is_chosen_later_loses_no_pose_and_no_gesture(speaker, take):
    scene = bpy.context.scene
    scene.frame_set(240)
    bone = next(one for one in speaker.pose.bones if "arm" in one.name.lower())
    bone.rotation_mode = "QUATERNION"
    bone.rotation_quaternion = bone.rotation_quaternion @ Quaternion((1, 0, 0), 0.8)
    bone.keyframe_insert("rotation_quaternion", frame=240)
    wanted = pose(speaker, 240)
    press(bpy.ops.s2ag.keep_pose)
    scene.frame_set(300)
    press(bpy.ops.s2ag.add_gesture, kind="point")
    at = gesture_edits.edits_of(now(speaker))[1]["at"]
    for operator, chosen in ((bpy.ops.s2ag.style_from, {"style": "stern"}), (bpy.ops.s2ag.feeling_from, {"mood": "sleepy"})):
        scene.frame_set(180)
        before = curves(now(speaker))
        assert press(operator, **chosen) == {"FINISHED"}
        assert not decisions.unmet(now(speaker)) and apart(wanted, pose(speaker, 240)) < 0.1
        shown = gesture_edits.shown_gestures(now(speaker), scene)
        assert any(one.kind == "point" and abs(one.at - at) < 0.15 for one in shown)
        assert moved(before, curves(now(speaker)), 200)
    assert [edit["do"] for edit in gesture_edits.edits_of(now(speaker))] == ["pose", "add", "style", "feel"]


def moved(before, after, frame):
    """Whether keys differ, and only from shortly before ``frame`` on."""
    pairs = [pair for key, points in before.items() for pair in zip(points, after[key], strict=True)]
    first = min((old[0] for old, new in pairs if old[1] != new[1]), default=0)
    return frame - 30 <= first <= frame + 30


@pytest.mark.slow
def test_rest_and_point_are_kinds(speaker, take):
    assert [name for name, *_ in menu_items.kinds()][:3] == ["beat", "rest", "point"]
    told = [sentence for name, _, sentence in menu_items.kinds() if name]
    assert all(told) and len(set(told)) == 92
    one = gesture_edits.shown_gestures(take, bpy.context.scene)[3]
    bpy.context.scene.frame_set(one.frame)
    assert press(bpy.ops.s2ag.change_gesture, kind="rest") == {"FINISHED"}
    left = gesture_edits.shown_gestures(now(speaker), bpy.context.scene)
    assert all(abs(other.at - one.at) > 0.2 for other in left)
    bpy.context.scene.frame_set(one.frame)
    assert press(bpy.ops.s2ag.add_gesture, kind="point") == {"FINISHED"}
    left = gesture_edits.shown_gestures(now(speaker), bpy.context.scene)
    assert any(other.kind == "point" and abs(other.at - one.at) < 0.15 for other in left)


def test_an_error_leaves_with_what_caused_it(speaker, take):
    scene = bpy.context.scene
    scene.use_preview_range = False
    with pytest.raises(RuntimeError, match="No preview range"):
        bpy.ops.s2ag.rest_range(what="PREVIEW")
    assert "No preview range" in session.messages(speaker)[0][0]
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 30, 90
    assert session.messages(speaker) == []


def test_sliders_that_cannot_vary_take_no_keys(speaker):
    assert speaker.keyframe_insert("s2ag.arousal", frame=1)
    with pytest.raises(TypeError, match="not animatable"):
        speaker.keyframe_insert("s2ag.meaning", frame=1)


def test_a_style_marker_is_put_at_the_playhead(speaker, take):
    bpy.context.scene.frame_set(77)
    assert bpy.ops.s2ag.mark_style(style="calm lecturer") == {"FINISHED"}
    assert [(one.name, one.frame) for one in bpy.context.scene.timeline_markers][-1] == ("as calm lecturer", 77)


def test_what_is_deleted_with_the_others_is_counted(speaker, take):
    assert take_list.others(speaker) == []
