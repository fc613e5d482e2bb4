"""What is changed while gestures come, and values that nobody sets: each ends in one sentence, and nothing changed."""

import bpy
import pytest
from s2ag.core.errors import RigUnusable, S2agError, UsageError
from s2ag.s2ag_blender.takes import generate


@pytest.fixture
def planned(figure, voice):
    figure.s2ag.audio = str(voice)
    return generate.plan(bpy.context, figure)


def faster(armature):
    bpy.context.scene.render.fps = 60


def without_bone(armature):
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bones = armature.data.edit_bones
    bones.remove(next(bone for bone in bones if "forearm" in bone.name.lower() or "lower_arm" in bone.name.lower()))
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("change", [faster, without_bone])
@pytest.mark.parametrize("slices", [0, 1, 2, 3])
def test_a_change_between_slices_is_told_and_leaves_nothing(planned, figure, wave, change, slices):
    before = set(bpy.data.actions)
    laying = generate.finish_in_slices(planned, {"motions": [wave(46)]})
    for _ in range(slices):
        next(laying)
    change(figure)
    with pytest.raises(S2agError) as caught:
        for _ in laying:
            pass
    assert caught.value.message and caught.value.remedy
    assert set(bpy.data.actions) == before and not len(figure.s2ag.takes)


def test_a_scene_of_a_million_frames_a_second_is_refused(figure, voice):
    figure.s2ag.audio = str(voice)
    bpy.context.scene.render.fps_base = 1e-5
    with pytest.raises(UsageError, match="frames a second"):
        generate.plan(bpy.context, figure)


def test_transforms_that_are_no_numbers_are_refused(figure, voice):
    figure.s2ag.audio = str(voice)
    figure.pose.bones[0].location.x = float("nan")
    with pytest.raises(RigUnusable, match="no number"):
        generate.plan(bpy.context, figure)
