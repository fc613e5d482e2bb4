"""A bone that is locked or ruled by a constraint refuses no run; what is left out is told in a panel's words."""

import bpy
import pytest
from acted import curves
from s2ag.s2ag_blender.rig import readiness, reading
from s2ag.s2ag_blender.takes import generate

pytestmark = pytest.mark.slow


def bone_of(armature, part):
    return armature.pose.bones[reading.detect_mapping(armature, reading.read(armature))[0].chains[part][0]]


def locked(armature, part):
    bone_of(armature, part).lock_rotation = (True, True, True)


def follows(armature, part):
    constraint = bone_of(armature, part).constraints.new("COPY_ROTATION")
    constraint.target, constraint.subtarget = armature, armature.data.bones[0].name


def reaches(armature, part):
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.collection.objects.link(goal)
    constraint = bone_of(armature, part).constraints.new("IK")
    constraint.target, constraint.chain_count = goal, 2


@pytest.mark.parametrize("without", [False, True], ids=["all", "without the left arm"])
@pytest.mark.parametrize("part", ["left_forearm", "left_upper_arm", "left_clavicle", "left_hand", "neck"])
@pytest.mark.parametrize("obstacle", [locked, follows, reaches])
def test_the_rest_gestures(figure, voice, wave, obstacle, part, without):
    obstacle(figure, part)
    bpy.context.view_layer.update()
    figure.s2ag.audio = str(voice)
    if without:
        figure.s2ag.parts = {"TORSO", "HEAD", "CLAVICLES", "RIGHT_ARM"}
    found = readiness.readiness_of(figure)
    assert not found.problem and bpy.ops.s2ag.generate.poll()
    outcome = generate.finish(generate.plan(bpy.context, figure), {"motions": [wave(8)]})
    keyed = {path.split('"')[1] for path, _ in curves(outcome.actions[0])}
    assert bone_of(figure, "right_forearm").name in keyed
    if obstacle is locked:
        assert bone_of(figure, part).name not in keyed
    assert not any("s2ag rig" in sentence or "--" in sentence for sentence in (*outcome.warnings, *found.warnings))


def test_where_all_arms_are_locked_the_trunk_gestures(figure, voice, wave):
    for part in ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm"):
        locked(figure, part)
    figure.s2ag.audio = str(voice)
    outcome = generate.finish(generate.plan(bpy.context, figure), {"motions": [wave(8)]})
    keyed = {path.split('"')[1] for path, _ in curves(outcome.actions[0])}
    assert bone_of(figure, "head").name in keyed and bone_of(figure, "left_forearm").name not in keyed
    assert any("rotation is locked" in sentence for sentence in outcome.warnings)
