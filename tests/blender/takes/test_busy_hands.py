"""An arm that is told busy, locked, or held by another object stays; the other one talks for both."""

from dataclasses import replace

import acted
import bpy
import numpy as np
import pytest
from acted import curves
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.keys import poses
from s2ag.s2ag_blender.rig import reading
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
    assert not [path for path in paths if "upper_arm.L" in path or "lower_arm.L" in path or "hand.L" in path]
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


def test_the_hand_that_talks_keeps_clear_of_the_arm_that_is_held(speaker, voice):
    """The other hand would go to the very place before the chest where a hand holds a cup: it gives way alone."""
    cup = bpy.data.objects.new("Cup", None)
    bpy.context.collection.objects.link(cup)
    pose = speaker.pose.bones
    cup.location = (0.0, pose["upper_arm.L"].head.y - 0.3, pose["upper_arm.L"].head.z - 0.25)
    held = pose["lower_arm.L"].constraints.new("IK")
    held.target, held.chain_count = cup, 2
    bpy.context.view_layer.update()
    bones = reading.read(speaker)
    both = poses.directions(speaker, bones, reading.resolve_mapping(speaker, bones))
    (left, right), mirror = skeleton.ARMS, [-1.0, 1.0, 1.0]
    both[list(right)] = both[list(left)] * mirror
    motion = Motion(np.repeat(both[None], 30, 0).astype(np.float32), fps=15.0)
    hands = Hands.of(
        motion.directions[:, FOREARMS], np.array([[[-1.0, 0, 0], [1.0, 0, 0]]] * 30), np.tile(handshape.RELAXED, (30, 2, 1))
    )
    acted.lay(speaker, replace(motion, hands=hands))
    bpy.context.scene.frame_set(20)
    wrists = [np.array(pose[f"hand.{side}"].head) for side in "LR"]
    np.testing.assert_allclose(wrists[0], cup.location, atol=1e-4)
    assert np.linalg.norm(wrists[0] - wrists[1]) > 0.035  # the heels of both hands, 0.14 of their 13 cm each, less their touch
