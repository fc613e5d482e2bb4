"""An arm that is told busy, locked, or held by another object stays; the other one talks for both."""

import acted
import bpy
import pytest
from acted import curves
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.takes import generate


def tell(figure):
    figure.s2ag.parts = {"TORSO", "HEAD", "CLAVICLES", "RIGHT_ARM"}


def lock(figure):
    figure.pose.bones["upper_arm.L"].lock_rotation = (True, True, True)


def hold(figure):
    cup = bpy.data.objects.new("Cup", None)
    bpy.context.collection.objects.link(cup)
    figure.pose.bones["hand.L"].constraints.new("COPY_LOCATION").target = cup


@pytest.mark.parametrize("busy", [tell, lock, hold])
def test_a_busy_arm_has_no_keys_and_the_other_hand_is_preferred(speaker, voice, busy):
    busy(speaker)
    planned = generate.plan(bpy.context, speaker)
    assert planned.params["hand"] == 1.0 and planned.settings["hand"] == 1.0 and "LEFT_ARM" not in planned.settings["parts"]
    assert bool([one for one in planned.warnings if "held or locked" in one]) == (busy is not tell)
    outcome = generate.wait(bpy.context, planned)
    paths = {path for path, _ in curves(outcome.actions[0])}
    assert not [path for path in paths if "upper_arm.L" in path or "forearm.L" in path or "hand.L" in path]
    assert [path for path in paths if "upper_arm.R" in path]
    assert provenance.read(outcome.actions[0])["hand"] == 1.0


def test_a_hand_that_holds_is_found_again_after_undo_and_in_a_saved_file(speaker, voice, tmp_path):
    bpy.ops.ed.undo_push(message="ready")
    hold(speaker)
    bpy.ops.ed.undo_push(message="holds")
    assert acted.press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.ops.ed.undo()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cup.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "cup.blend"))
    figure = bpy.data.objects["Mannequin"]
    assert not figure.s2ag.takes and generate.plan(bpy.context, figure).params["hand"] == 1.0


def test_free_arms_and_arms_of_control_rigs_are_not_busy(speaker):
    speaker.pose.bones["hand.L"].constraints.new("IK").target = speaker  # a control bone of its own
    planned = generate.plan(bpy.context, speaker)
    assert planned.params["hand"] == 0 and "LEFT_ARM" in planned.settings["parts"]


def test_both_busy_leaves_head_and_trunk(speaker):
    speaker.s2ag.parts = {"TORSO", "HEAD", "CLAVICLES"}
    planned = generate.plan(bpy.context, speaker)
    assert planned.params["hand"] == 0
