"""Keys of a shifting weight, however they are laid: feet stay on all frames."""

from dataclasses import replace

import bpy
import handed
import numpy as np
import pytest
import rigging
from acted import curves, lay
from bodies import performance
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.keys import density

FRAMES = range(10, 83, 3)
SLIDES = 0.005
"""Metres."""
LEGS = [f"{bone}.{side}" for bone in ("thigh", "shin", "foot") for side in "LR"]


def motion():
    directions = performance(46)
    return Motion(directions, meta={"style": "test"}, hands=handed.hands(directions), pelvis=handed.pelvis(46))


def slid(armature):
    """How far the feet get from where they stand at rest, and the hips from one side to the other, in metres."""
    poses = [rigging.evaluated(armature, frame) for frame in FRAMES]
    rest = {bone.name: np.array(bone.matrix_local) for bone in armature.data.bones}
    feet = max(np.abs(pose[name] - rest[name])[:3, 3].max() for pose in poses for name in ("foot.L", "foot.R"))
    return feet, np.ptp([pose["hips"][0, 3] for pose in poses])


@pytest.mark.parametrize(
    "settings",
    [
        {"curves": "FRAMES"},
        {"curves": "FRAMES", "key_step": 3},
        {"curves": "POSES", "tolerance": np.radians(2.0)},
        {"result": "STRIP"},
        {"result": "LAYER"},
        {"result": "LAYER", "influence": 0.5},
        {"start_pose": "CURRENT", "end_pose": "CURRENT", "blend_in": 12, "blend_out": 12},
        {"smoothing": 0.4},
        {"speed": 1.5},
    ],
    ids=str,
)
def test_feet_stay(actor, settings):
    lay(actor, motion(), **settings)
    feet, hips = slid(actor)
    assert feet < SLIDES
    assert hips > 0.02


def test_blending_starts_and_ends_at_rest(actor):
    lay(actor, motion(), curves="FRAMES", start_pose="CURRENT", end_pose="CURRENT", blend_in=10, blend_out=10)
    first, last = (rigging.evaluated(actor, frame) for frame in (10, int(actor.animation_data.action.frame_range[1])))
    for bone in ("hips", "thigh.L", "shin.R"):
        rest = np.array(actor.data.bones[bone].matrix_local)
        np.testing.assert_allclose(first[bone], rest, atol=1e-4)
        np.testing.assert_allclose(last[bone], rest, atol=1e-4)


def test_few_keys_of_all_frames_still_hold_the_feet(actor):
    (action,) = lay(actor, motion(), curves="FRAMES")
    every = len(curves(action)['pose.bones["shin.L"].rotation_quaternion', 0])
    density.convert(actor, action, np.radians(3.0), bpy.context.scene.render.fps)
    assert len(curves(action)['pose.bones["shin.L"].rotation_quaternion', 0]) < 0.5 * every
    assert slid(actor)[0] < SLIDES


def test_a_take_without_it_leaves_the_legs_alone(actor):
    lay(actor, motion())
    (action,) = lay(actor, replace(motion(), pelvis=None))
    assert not [key for key in curves(action) if any(f'"{bone}"' in key[0] for bone in ("hips", *LEGS))]
    feet, hips = slid(actor)
    assert feet < 1e-6 and hips < 1e-6


def test_a_trunk_that_is_not_keyed_is_not_turned(actor):
    lay(actor, motion(), parts={"HEAD", "CLAVICLES", "LEFT_ARM", "RIGHT_ARM"})
    rest = np.array(actor.data.bones["hips"].matrix_local)[:3, :3]
    for frame in FRAMES:
        np.testing.assert_allclose(rigging.evaluated(actor, frame)["hips"][:3, :3], rest, atol=1e-4)
    feet, hips = slid(actor)
    assert feet < SLIDES and hips < SLIDES
