"""One press: every selected character waits in its own way, in one undo step, and the panel is never held for long."""


import bpy
import numpy as np
import pytest
from acted import drawn, press
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.keys import layers
from s2ag.s2ag_blender.ui import gesture_panel, idle, subpanels


@pytest.fixture
def crowd(extension):
    figures = [mannequin.build().armature for _ in range(3)]
    for figure in figures:
        figure.select_set(True)
    bpy.context.view_layer.objects.active = figures[0]
    return figures


def wrists(figure, frames):
    rows = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        pose = figure.pose.bones
        rows.append([*pose["hand.L"].head, *pose["hand.R"].head, *pose["head"].tail])
    return np.array(rows)


def test_everyone_selected_waits_in_a_way_of_its_own(crowd):
    assert bpy.ops.s2ag.idle(seconds=4) == {"FINISHED"}
    actions = [figure.animation_data.action for figure in crowd]
    assert [provenance.read(action)["seed"] for action in actions] == [0, 1, 2]
    assert {tuple(action.frame_range) for action in actions} == {(1.0, 97.0)}
    paths = [wrists(figure, range(1, 98)) for figure in crowd]
    assert min(np.abs(a - b).max() for a, b in ((paths[0], paths[1]), (paths[1], paths[2]))) > 0.02
    for path in paths:
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert steps.min() > 1e-5  # never a statue
        assert np.abs(path[-1] - path[0]).max() < 1e-4
        assert np.linalg.norm(np.diff(path, axis=0)[0] - np.diff(path, axis=0)[-1]) < max(4 * np.median(steps), 0.004)


def test_who_sits_waits_on_across_the_seam_of_a_loop(crowd):
    for figure in crowd:
        figure.s2ag.seated = "ON"
    assert bpy.ops.s2ag.idle(seconds=6, stillness=0.2) == {"FINISHED"}
    for figure in crowd:
        path = wrists(figure, range(1, 146))
        speeds = np.diff(path, axis=0)
        jumps = np.linalg.norm(np.diff(np.concatenate([speeds, speeds[:1]]), axis=0), axis=1)
        assert np.abs(path[-1] - path[0]).max() < 1e-4 and jumps[-1] <= np.percentile(jumps, 99)
        assert np.linalg.norm(speeds, axis=1).min() > 1e-5


def test_an_idle_is_a_take_that_comes_back_by_a_click_and_plays_on_below_what_is_said(crowd):
    figure = crowd[0]
    first, second = (bpy.ops.s2ag.idle(seconds=2) and figure.animation_data.action for _ in range(2))
    assert [(take.title, take.first, take.last) for take in figure.s2ag.takes] == [("Idle 1", 1, 49), ("Idle 2", 1, 49)]
    assert [action.name for action in (first, second)] == [f"{figure.name} – Idle {number}" for number in (1, 2)]
    figure.s2ag.active_take = 0
    assert "Idle 1 from frame 1" in drawn(subpanels.S2AG_PT_takes)
    assert figure.animation_data.action == first and drawn(gesture_panel.S2AG_PT_directing)["No gestures are known"]
    assert layers.base_action(figure, 10, 20) == first
    for button in (bpy.ops.s2ag.reroll, bpy.ops.s2ag.vary, bpy.ops.s2ag.recall_take, bpy.ops.s2ag.change_gesture):
        assert not button.poll()
    assert bpy.ops.s2ag.delete_take() == {"FINISHED"}
    assert [take.title for take in figure.s2ag.takes] == ["Idle 2"] and figure.animation_data.action == second


def test_legs_and_root_stay_in_place(crowd):
    place = crowd[0].matrix_world.copy()
    bpy.ops.s2ag.idle(seconds=2, stillness=1.0)
    assert crowd[0].matrix_world == place


def test_the_strip_of_an_idle_leaves_the_action_alone(crowd):
    crowd[0].s2ag.result = "STRIP"
    bpy.ops.s2ag.idle(seconds=2)
    data = crowd[0].animation_data
    assert data.action is None and len(data.nla_tracks) == 1


def test_a_seated_idle_is_undone_in_one_step_and_made_alike_from_a_saved_file(crowd, tmp_path):
    for figure in crowd:
        figure.s2ag.seated, figure.s2ag.table = "ON", 1.1
    names = [figure.name for figure in crowd]
    bpy.ops.ed.undo_push(message="ready")
    press(bpy.ops.s2ag.idle, seconds=2)
    bpy.ops.ed.undo()
    crowd = [bpy.data.objects[name] for name in names]
    assert not [one for one in crowd if one.animation_data and one.animation_data.action] and crowd[2].s2ag.seated == "ON"

    bpy.ops.s2ag.idle(seconds=2)
    frames = range(1, 49, 6)
    before = [wrists(figure, frames) for figure in crowd]
    assert min(path[:, [2, 5]].min() for path in before) > 1.1  # hands lie on the table
    for path in (tmp_path / "waits.blend", tmp_path / "again.blend"):
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        bpy.ops.wm.open_mainfile(filepath=str(path))
        crowd = [bpy.data.objects[name] for name in names]
        assert [one.s2ag.seated for one in crowd] == ["ON"] * 3 and crowd[0].s2ag.table == pytest.approx(1.1)
        assert np.abs(np.subtract([wrists(figure, frames) for figure in crowd], before)).max() < 1e-6
        bpy.ops.s2ag.idle(seconds=2)


def test_blender_is_let_go_between_characters_and_what_is_broken_off_leaves_nothing(crowd):
    slices = idle.idle_in_slices(crowd, 1, bpy.context.scene, 20.0, 0.5, True)
    shares = [next(slices) for _ in range(3)]
    assert shares[0] == 0.0
    while not bpy.data.actions:
        next(slices)
    slices.close()
    assert not [action for action in bpy.data.actions if action.users == 0] or not bpy.data.actions


def test_what_has_no_arms_is_told_and_the_others_wait(crowd):
    bpy.ops.object.armature_add()
    bone = bpy.context.active_object
    for figure in crowd:
        figure.select_set(True)
    bpy.context.view_layer.objects.active = crowd[0]
    assert bpy.ops.s2ag.idle(seconds=2) == {"FINISHED"}
    assert bone.animation_data is None and all(figure.animation_data.action for figure in crowd)


def test_why_weight_does_not_shift_is_told_by_the_button(crowd, capfd):
    """Not to the console alone, as a log's line is."""
    leg = crowd[0].pose.bones["thigh.L"]
    leg.rotation_mode, leg.rotation_quaternion = "QUATERNION", (0.8, 0.6, 0, 0)
    crowd[0].s2ag.stance = 1.0
    assert bpy.ops.s2ag.idle(seconds=2) == {"FINISHED"}
    told = [line for line in capfd.readouterr().out.splitlines() if "weight does not shift" in line]
    assert told and all(line.startswith("Warning: ") for line in told), told
