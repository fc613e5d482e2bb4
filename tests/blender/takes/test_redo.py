"""The redo panel (F9) of every button that edits a take: it stays about what was chosen when the button was pressed.

Blender undoes the step and runs the operator again with all its properties, one of them changed; the move of the playhead is no
undo step, so that it is elsewhere then, and so may be what is selected.
"""

import bpy
import pytest
from acted import now, press
from s2ag.s2ag_blender import registration
from s2ag.s2ag_blender.takes import gesture_edits
from s2ag.s2ag_blender.ui.directing import Directing

CASES = {
    "change_gesture": ({"size": 1.6}, {"size": 1.3}),
    "delete_gesture": ({}, {}),
    "delete_gesture selected": ({"what": "SELECTED"}, {}),
    "add_gesture": ({"kind": "beat"}, {"kind": "big"}),
    "apply_markers": ({}, {}),
    "reroll_range": ({"what": "PREVIEW"}, {}),
    "reroll_range markers": ({"what": "MARKERS"}, {}),
    "rest_range": ({"what": "PREVIEW"}, {"how": "fewer"}),
    "rest_range gestures": ({"what": "GESTURES"}, {"how": "calmer"}),
    "keep_pose": ({"what": "PLAYHEAD"}, {}),
    "keep_place": ({"hand": "left", "pointing": True}, {"hand": "right"}),
    "style_from": ({"style": "stern"}, {"style": "tired"}),
    "feeling_from": ({"mood": "excited"}, {"strength": 0.4}),
    "switch_decision": ({"number": 0}, {}),
    "change_decision": ({"number": 0, "how": "fewer"}, {"how": "calmer"}),
    "remove_decision": ({"number": 0}, {}),
}
"""Operators, and what their redo panel changes from and to."""
EDITED = {"switch_decision", "change_decision", "remove_decision"}


def armature():
    """The character, which undo makes another object of."""
    return bpy.data.objects["Mannequin"]


def choose(first, second, third, frames):
    """Playhead, selections and preview range at one place of the take, or at another one."""
    scene, action = bpy.context.scene, now(armature())
    scene.frame_set(first.frame)
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, *frames
    for marker in action.pose_markers:
        marker.select = marker.name in (second.name, third.name)
    for marker in scene.timeline_markers:
        marker.select = frames[0] <= marker.frame <= frames[1]


@pytest.fixture
def stage(speaker, take):
    """A take with something to point at, markers, and gestures to choose from."""
    scene = bpy.context.scene
    target = bpy.data.objects.new("target", None)
    scene.collection.objects.link(target)
    target.location = 0.6, -1.5, 1.4
    speaker.s2ag.target = target
    for frame in (60, 120, 240, 300):
        scene.timeline_markers.new(f"m{frame}", frame=frame)
    return gesture_edits.shown_gestures(take, scene)


def remembered(operator):
    """All properties with which the redo panel would run an operator again."""
    values = {}
    for name, prop in operator.properties.bl_rna.properties.items():
        if name != "rna_type":
            value = getattr(operator.properties, name)
            values[name] = tuple(value) if getattr(prop, "is_array", False) else value
    return values


@pytest.mark.parametrize("case", CASES)
def test_what_was_chosen_is_what_is_changed(stage, case):
    name, (first, changed) = case.split()[0], CASES[case]
    operator, shown = getattr(bpy.ops.s2ag, name), stage
    choose(shown[2], shown[3], shown[4], (60, 120))
    if name in EDITED:
        press(bpy.ops.s2ag.rest_range, what="PREVIEW")
    if name == "apply_markers":
        now(armature()).pose_markers[shown[3].name].frame += 4
    bpy.ops.ed.undo_push(message="chosen")
    assert press(operator, **first) == {"FINISHED"}
    once = gesture_edits.edits_of(now(armature()))
    asked = remembered(bpy.context.window_manager.operators[-1])
    bpy.ops.ed.undo()
    assert gesture_edits.edits_of(now(armature())) != once
    choose(shown[-3], shown[-4], shown[-2], (240, 300))
    assert press(operator, **{**asked, **changed}) == {"FINISHED"}
    again = gesture_edits.edits_of(now(armature()))
    assert len(again) == len(once) and [at(edit) for edit in again] == [at(edit) for edit in once]
    assert (again != once) == bool(changed)


def at(edit):
    """What an edit is about."""
    return {key: edit.get(key) for key in ("do", "at", "from", "to")}


def test_every_button_that_edits_a_take_has_a_case():
    own = [one for one in registration.CLASSES if issubclass(one, Directing)]
    assert {one.bl_idname.removeprefix("s2ag.") for one in own} == {case.split()[0] for case in CASES}
