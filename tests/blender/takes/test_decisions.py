"""What was decided is kept as a list: each can be switched off, changed and removed; a button edits what it was pressed for."""

import bpy
import numpy as np
import pytest
from acted import apart, curves, drawn, now, pose, press
from mathutils import Quaternion
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.takes import decisions, gesture_edits, versions
from s2ag.s2ag_blender.ui import decisions as panel
from s2ag.s2ag_blender.ui import gesture_panel
from s2ag.s2ag_blender.ui import panel as main_panel


def shown(armature):
    return gesture_edits.shown_gestures(now(armature), bpy.context.scene)


def go(one):
    bpy.context.scene.frame_set(one.frame)


def same(one, other):
    """Whether two versions have the same keys, to what solving a rig rounds."""
    first, second = (found if isinstance(found, dict) else curves(found) for found in (one, other))
    return first.keys() == second.keys() and all(np.allclose(first[key], second[key], atol=2e-3) for key in first)


def pressed_again(operator, playhead, **changes):
    """Press a button, move the playhead, which is no undo step, and change a value in the redo panel: undo, and do it again."""
    before = len(bpy.context.window_manager.operators)
    press(operator, **changes.pop("first"))
    last = bpy.context.window_manager.operators[-1]
    assert len(bpy.context.window_manager.operators) > before or last.bl_idname
    asked = {name: getattr(last.properties, name) for name in ("about", "chosen")}
    asked["about"] = tuple(asked["about"])
    bpy.ops.ed.undo()
    bpy.context.scene.frame_set(playhead)
    return press(operator, **asked, **changes)


def test_the_redo_panel_changes_the_gesture_that_the_button_was_pressed_for(speaker, take):
    one, other = shown(speaker)[4], shown(speaker)[-3]
    bpy.ops.ed.undo_push()
    go(one)
    pressed_again(bpy.ops.s2ag.change_gesture, other.frame, first={"size": 1.6}, size=1.3)
    (edit,) = gesture_edits.edits_of(now(bpy.data.objects["Mannequin"]))
    assert edit["at"] == pytest.approx(one.at, abs=1e-3) and edit["size"] == 1.3


def test_the_redo_panel_adds_where_the_playhead_was(speaker, take):
    bpy.ops.ed.undo_push()
    bpy.context.scene.frame_set(180)
    wanted = gesture_edits.seconds_at(take, bpy.context.scene, 180)
    pressed_again(bpy.ops.s2ag.add_gesture, 60, first={"kind": "beat"}, kind="big")
    (edit,) = gesture_edits.edits_of(now(bpy.data.objects["Mannequin"]))
    assert edit["at"] == pytest.approx(wanted, abs=1e-3) and edit["kind"] == "big"


def test_the_redo_panel_keeps_the_range(speaker, take):
    scene = bpy.context.scene
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 60, 120
    bpy.ops.ed.undo_push()
    press(bpy.ops.s2ag.rest_range)
    last = bpy.context.window_manager.operators[-1].properties
    asked = {"about": tuple(last.about), "chosen": last.chosen}
    (first,) = gesture_edits.edits_of(now(bpy.data.objects["Mannequin"]))
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    scene.frame_preview_start, scene.frame_preview_end = 150, 200
    press(bpy.ops.s2ag.rest_range, how="fewer", **asked)
    (edit,) = gesture_edits.edits_of(now(bpy.data.objects["Mannequin"]))
    assert (edit["from"], edit["to"], edit["how"]) == (first["from"], first["to"], "fewer")


def test_a_passage_rests_between_markers_of_any_kind(speaker, take):
    scene = bpy.context.scene
    for frame in (90, 240):
        scene.timeline_markers.new(f"m{frame}", frame=frame).select = True
    assert press(bpy.ops.s2ag.rest_range, what="MARKERS") == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert edit["do"] == "rest"
    # Going home at the begin and rising again at the end may each be fast enough for a stroke.
    assert not [one for one in shown(speaker) if edit["from"] + 1 <= one.at <= edit["to"] - 1]


def test_several_are_deleted_in_one_edit(speaker, take):
    before = shown(speaker)
    for one in before[3:6]:
        take.pose_markers[one.name].select = True
    assert press(bpy.ops.s2ag.delete_gesture, what="SELECTED") == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert len(edit["at"]) == 3 and abs(len(shown(speaker)) - (len(before) - 3)) <= 1


def test_markers_that_are_gone_are_one_edit(speaker, take):
    for one in shown(speaker)[3:6]:
        take.pose_markers.remove(take.pose_markers[one.name])
    assert press(bpy.ops.s2ag.apply_markers) == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert len(edit["at"]) == 3


def test_a_version_is_named_after_what_it_did(speaker, take):
    one = shown(speaker)[4]
    go(one)
    press(bpy.ops.s2ag.change_gesture, size=1.6)
    held = speaker.s2ag.takes[0]
    assert versions.version_title(held).startswith("× 1.6, ") and f"{one.at:.1f} s" in versions.version_title(held)
    held.warnings = "Short told."
    assert {versions.version_title(held), held.warnings} <= drawn(gesture_panel.S2AG_PT_directing).keys()
    assert held.warnings not in drawn(main_panel.S2AG_PT_gestures)  # where the buttons that flip would jump with it
    press(bpy.ops.s2ag.flip_version, back=True)
    assert "As it was generated" in drawn(gesture_panel.S2AG_PT_directing)


def test_one_decision_is_taken_back_and_had_again(speaker, take):
    first, second = shown(speaker)[3], shown(speaker)[-4]
    go(first)
    press(bpy.ops.s2ag.change_gesture, size=1.6)
    one = curves(now(speaker))
    go(second)
    press(bpy.ops.s2ag.delete_gesture)
    both = curves(now(speaker))
    words = [decisions.words_of(edit, now(speaker)) for edit in gesture_edits.edits_of(now(speaker))]
    told = " ".join(drawn(panel.S2AG_PT_decisions))  # long ones are wrapped
    assert all(f"{number} {text}" in told for number, text in enumerate(words, 1))
    press(bpy.ops.s2ag.switch_decision, number=1)
    assert same(one, now(speaker)) and [edit.get("off") for edit in gesture_edits.edits_of(now(speaker))] == [None, True]
    assert versions.version_title(speaker.s2ag.takes[0]).startswith("Off: ")
    press(bpy.ops.s2ag.switch_decision, number=1)
    assert same(both, now(speaker))
    press(bpy.ops.s2ag.remove_decision, number=0)
    assert [edit["do"] for edit in gesture_edits.edits_of(now(speaker))] == ["delete"]
    press(bpy.ops.s2ag.remove_decision, number=0)
    assert same(take, now(speaker)) and not gesture_edits.edits_of(now(speaker))
    assert "Taken back" in versions.version_title(speaker.s2ag.takes[0])


def test_a_decision_is_changed(speaker, take):
    go(shown(speaker)[4])
    press(bpy.ops.s2ag.change_gesture, size=1.6)
    press(bpy.ops.s2ag.change_decision, number=0, size=0.7)
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert edit["size"] == 0.7
    with pytest.raises(RuntimeError, match="Nothing is to be changed"):
        press(bpy.ops.s2ag.change_decision, number=0, size=1.0)


def test_what_is_not_possible_without_a_decision_is_said(speaker, take):
    one = shown(speaker)[4]
    take.pose_markers[one.name].frame += 12
    press(bpy.ops.s2ag.apply_markers)
    (move,) = gesture_edits.edits_of(now(speaker))
    there = min(shown(speaker), key=lambda other: abs(other.at - move["to"]))
    go(there)
    press(bpy.ops.s2ag.change_gesture, size=0.7)
    press(bpy.ops.s2ag.switch_decision, number=0)
    lost = decisions.unmet(now(speaker))
    nearest = min(abs(other.at - there.at) for other in gesture_edits.shown_gestures(take, bpy.context.scene))
    assert (lost == {1}) == (nearest > 0.25)
    assert bool(lost) == ("left out" in speaker.s2ag.takes[0].warnings)


def test_a_kept_pose_is_off_and_on_again(speaker, take):
    scene, posed = bpy.context.scene, speaker.pose.bones
    frame = 150
    scene.frame_set(frame)
    bone = next(one for one in posed if "arm" in one.name.lower())
    bone.rotation_mode = "QUATERNION"
    bone.rotation_quaternion = bone.rotation_quaternion @ Quaternion((1, 0, 0), 0.8)
    bone.keyframe_insert("rotation_quaternion", frame=frame)
    wanted = pose(speaker, frame)
    press(bpy.ops.s2ag.keep_pose)
    assert apart(wanted, pose(speaker, frame)) < 0.1
    press(bpy.ops.s2ag.switch_decision, number=0)
    press(bpy.ops.s2ag.switch_decision, number=0)
    assert apart(wanted, pose(speaker, frame)) < 0.1
    assert provenance.read(now(speaker))["edits"][0]["do"] == "pose"


def test_generate_keeps_the_decisions_about_the_selected_take(speaker, take):
    go(shown(speaker)[4])
    press(bpy.ops.s2ag.change_gesture, size=1.6)
    scene = bpy.context.scene
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 60, 120
    press(bpy.ops.s2ag.rest_range)
    edits = gesture_edits.edits_of(now(speaker))
    speaker.s2ag.style = "calm lecturer"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    assert len(speaker.s2ag.takes) == 2 and gesture_edits.edits_of(now(speaker)) == edits
    assert 1 not in decisions.unmet(now(speaker))  # a passage can rest in any style
    assert (0 in decisions.unmet(now(speaker))) == ("left out" in speaker.s2ag.takes[1].warnings)
    assert press(bpy.ops.s2ag.generate, keep_decisions=False) == {"FINISHED"}
    assert gesture_edits.edits_of(now(speaker)) == []


def test_generate_says_why_decisions_stay_behind(speaker, take):
    go(shown(speaker)[4])
    press(bpy.ops.s2ag.change_gesture, size=1.6)
    speaker.s2ag.take_count = 2
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    assert "only a single take can keep them" in speaker.s2ag.takes[1].warnings


def test_a_style_begins_at_the_playhead(speaker, take):
    bpy.context.scene.frame_set(180)
    assert press(bpy.ops.s2ag.style_from, style="calm lecturer") == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert edit["do"] == "style" and edit["at"] == gesture_edits.seconds_at(take, bpy.context.scene, 180)
