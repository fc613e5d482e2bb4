"""Curves that an animator can edit: few keys, where they matter, and nothing lost outside them."""

import json

import bpy
import numpy as np
import pytest
from acted import animate, apart, curves, lay, pose, press
from bodies import performance
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.keys import curve_targets, density, key_reduction, keyframes, layers, pacing
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import take_list

pytestmark = pytest.mark.slow

FRAMES = range(10, 83, 4)


def speech(frames=46) -> Motion:
    """The right forearm beats three times and holds between, the left one rests, the head nods slowly."""
    pose = np.repeat(skeleton.REST[None], frames, 0).astype(float)
    lift = np.zeros(frames)
    for start in (4, 18, 32):
        rise = np.clip((np.arange(frames) - start) / 4, 0, 1) - np.clip((np.arange(frames) - start - 8) / 4, 0, 1)
        lift += rise * rise * (3 - 2 * rise)
    pose[:, skeleton.EDGE_NAMES.index("right_forearm")] += np.outer(lift, (0, -1.5, 1.0))
    pose[:, skeleton.EDGE_NAMES.index("head"), 2] += 0.2 * np.sin(np.linspace(0, 3, frames))
    return Motion(skeleton.normalize(pose).astype(np.float32), meta={"style": "test"})


def bones_of(armature, part):
    return reading.resolve_mapping(armature, reading.read(armature)).chains[part]


def keys_of(action):
    """How many keys the curves of bones have."""
    return sum(len(points) for points in curves(action).values())


@pytest.mark.parametrize("tolerance", [0.3, 2.0])
@pytest.mark.parametrize(
    "motion, share",
    [(speech(), {0.3: 0.9, 2.0: 0.5}), (Motion(performance(46), meta={"style": "test"}), {0.3: 1.0, 2.0: 0.6})],
    ids=["speech", "restless"],
)
def test_few_keys_show_the_gestures_within_the_tolerance(actor, motion, share, tolerance):
    (every,) = lay(actor, motion, curves="FRAMES")
    dense, wanted = keys_of(every), [pose(actor, frame) for frame in FRAMES]
    (few,) = lay(actor, motion, curves="POSES", tolerance=np.radians(tolerance))
    assert keys_of(few) < share[tolerance] * dense
    depth = 1 + max(len(bone.parent_recursive) for bone in actor.pose.bones)
    for frame, before in zip(FRAMES, wanted, strict=True):
        assert apart(before, pose(actor, frame)) < depth * tolerance + 0.05  # each bone adds to what it hangs on
    moving = [curve.keyframe_points for curve in compat.curves(few) if len(curve.keyframe_points) > 1]  # fingers are at ease
    assert {point.interpolation for points in moving for point in points} == {"BEZIER"}


def test_bones_of_a_limb_are_keyed_together_where_strokes_and_holds_are(actor):
    (action,) = lay(actor, speech(), tolerance=np.radians(2.0))
    kinds = {}
    for curve in compat.curves(action):
        for point in curve.keyframe_points:
            kinds.setdefault(curve.data_path.split('"')[1], {})[round(point.co[0])] = point.type
    (upper, *_), (fore, *_) = bones_of(actor, "right_upper_arm"), bones_of(actor, "right_forearm")
    beats = {frame for frame, kind in kinds[fore].items() if kind in ("EXTREME", "MOVING_HOLD")}
    assert len(beats) >= 4 and beats <= set(kinds[upper]) and "MOVING_HOLD" in kinds[fore].values()


def test_keys_are_dense_on_a_click_and_few_again_and_edits_stay(actor):
    foot = actor.data.bones[0].name
    animate(actor, [foot], frames=(1, 30, 120))
    lay(actor, speech())
    take = take_list.active(actor)
    before, few = [pose(actor, frame) for frame in FRAMES], keys_of(take.action)
    ours = json.loads(take.action[density.KEYED])
    walk = {key: points for key, points in curves(take.action).items() if key[0] not in ours}
    assert any(foot in path for path, _ in walk)
    press(bpy.ops.s2ag.change_keys)
    assert density.is_dense(take.action) and keys_of(take.action) > 2 * few
    assert max(apart(one, pose(actor, frame)) for one, frame in zip(before, FRAMES, strict=True)) < 0.01
    found = curves(take.action)
    assert all(np.array_equal(found[key], points) for key, points in walk.items())
    (fore, *_) = bones_of(actor, "left_forearm")
    for curve in compat.curves(take.action):
        if fore in curve.data_path:
            for point in curve.keyframe_points:
                point.co[1] += 0.1
    edited = pose(actor, 40)[fore]
    press(bpy.ops.s2ag.change_keys)
    assert not density.is_dense(take.action) and keys_of(take.action) < 2 * few
    assert apart({fore: edited}, {fore: pose(actor, 40)[fore]}) < 3


def values(action, frames):
    """``{(path, index): values}`` of every curve on frames, sub-frames too."""
    found = compat.curves(action)
    return {(one.data_path, one.array_index): np.array([one.evaluate(frame) for frame in frames]) for one in found}


@pytest.mark.parametrize("kept", ["POSES", "FRAMES"])
@pytest.mark.parametrize("blend", [0, 8])
@pytest.mark.parametrize("keys", [(1, 120), (1, 5, 30, 90, 120), (30, 60), (9, 10, 83), (95, 120), (1, 4)])
def test_what_lies_outside_the_range_stays_exactly_as_it_was(actor, keys, blend, kept):
    arm, head = bones_of(actor, "left_upper_arm")[0], bones_of(actor, "head")[0]
    walk = animate(actor, [arm, head], frames=keys, turn=1.5)
    for curve in compat.curves(walk):
        for number, point in enumerate(curve.keyframe_points):
            point.co[1] += 0.1 * (-1) ** number
            point.interpolation = "BEZIER"
            point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"
        curve.update()
    frames = np.concatenate([np.arange(-5, 9.01, 0.25), np.arange(83.0, 140, 0.25)])
    before = values(walk, frames)
    (made,) = lay(actor, speech(), blend_in=blend, blend_out=blend, curves=kept)
    place = layers.Place.of(made)
    assert (place.first, place.last) == (10, 82)
    after = values(made, frames)
    for key, wanted in before.items():
        np.testing.assert_allclose(after[key], wanted, atol=2e-5)


@pytest.mark.parametrize("kind", ["ALIGNED", "AUTO_CLAMPED", "FREE"])
def test_a_key_on_the_edge_does_not_turn_with_the_handle_inside(actor, kind):
    bone = bones_of(actor, "head")[0]
    path = f'pose.bones["{bone}"].rotation_euler'
    action, _, bag = compat.new_action("edges", actor)
    curve = bag.fcurves.new(path, index=0)
    for frame, value in ((1, 0.0), (20, 1.0), (40, 1.0), (60, 1.0), (70, 0.3)):
        point = curve.keyframe_points.insert(frame, value)
        point.handle_left_type = point.handle_right_type = kind
    curve.update()
    outside = np.concatenate([np.arange(-5, 20.01, 0.25), np.arange(40, 80, 0.25)])
    before, frames = values(action, outside), np.arange(20.0, 41.0)
    column = 1 + np.sin((frames - 20) * np.pi / 10)  # steep where it meets what was there
    thinner = key_reduction.KeyReducer({}, {}, frames, 24.0, 0.01)
    keyed = [keyframes.Channels(bone, path, {0: column})]
    keyframes.write_channels(bag, keyed, frames, "BEZIER", thinner, {(path, 0)})
    np.testing.assert_allclose(values(action, outside)[path, 0], before[path, 0], atol=2e-5)
    assert values(action, [25.0])[path, 0] > 1.9


@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
def test_bones_that_gesture_no_more_stand_as_before(actor, result):
    (fore, *_) = bones_of(actor, "right_forearm")
    actor.pose.bones[fore].rotation_mode = "XYZ"
    actor.pose.bones[fore].rotation_euler = (0.1, 0.2, 0.3)
    lay(actor, speech(), result=result)
    bpy.context.scene.frame_set(24)
    assert abs(actor.pose.bones[fore].rotation_euler[0] - 0.1) > 0.05
    lay(actor, speech(), result=result, parts={"TORSO", "HEAD", "LEFT_ARM"})
    for frame in (10, 24, 60):
        bpy.context.scene.frame_set(frame)
        assert np.allclose(actor.pose.bones[fore].rotation_euler, (0.1, 0.2, 0.3), atol=1e-6)
    actor.s2ag.active_take = 0
    bpy.context.scene.frame_set(24)
    assert abs(actor.pose.bones[fore].rotation_euler[0] - 0.1) > 0.05
    take_list.delete(actor, [0, 1])
    bpy.context.scene.frame_set(24)
    assert np.allclose(actor.pose.bones[fore].rotation_euler, (0.1, 0.2, 0.3), atol=1e-6)


def test_speed_makes_strokes_faster_and_leaves_the_beats():
    motion, speed = speech(), {}
    for factor in (0.6, 1.0, 1.6):
        paced = pacing.change_speed(motion, factor)
        assert len(paced.directions) == len(motion.directions) and paced.fps == motion.fps
        speed[factor] = np.quantile(np.linalg.norm(np.diff(paced.directions[:, 8], axis=0), axis=-1), 0.95)
        turns = np.concatenate([[0], pacing._turning_points(motion), [45]])
        np.testing.assert_allclose(paced.directions[turns], motion.directions[turns], atol=1e-6)
    assert speed[0.6] < speed[1.0] < speed[1.6]
    assert pacing.change_speed(motion, 1.0) is motion


def test_smoothing_evens_out_and_leaves_stillness(actor):
    random = np.random.default_rng(2).normal(size=(80, 4)).cumsum(0) * 0.05 + (3, 0, 0, 0)
    shaky = random / np.linalg.norm(random, axis=-1, keepdims=True)
    still = np.repeat(shaky[:1], 80, 0)
    found = pacing.smooth_rotations({"a": shaky, "b": still, "c": shaky[:1]}, 24, 0.4)
    assert np.abs(np.diff(found["a"], 2, axis=0)).mean() < 0.2 * np.abs(np.diff(shaky, 2, axis=0)).mean()
    np.testing.assert_allclose(found["b"], still, atol=1e-9)
    np.testing.assert_array_equal(found["c"], shaky[:1])
    jerk = []
    for seconds in (0.0, 0.5):
        (made,) = lay(actor, Motion(performance(46), meta={"style": "test"}), curves="FRAMES", smoothing=seconds)
        moving = [points[:, 1] for points in curves(made).values() if len(points) > 3]
        jerk.append(np.mean([np.abs(np.diff(column, 2)).mean() for column in moving]))
    assert jerk[1] < 0.5 * jerk[0]


def test_stillness_has_no_beats():
    found = key_reduction.beats(np.zeros(40), 24)
    assert not len(found.rows)
    kept = key_reduction.reduce_keys(np.arange(40.0), np.ones((40, 4)), 1e-3, found)
    assert kept.rows.tolist() == [0, 39] and kept.kinds == ("KEYFRAME", "KEYFRAME")


def test_curves_that_pass_through_their_targets_get_no_keys(actor):
    bone = actor.pose.bones[0]
    for frame, at in ((1, 0.0), (40, 0.2)):
        bone.location = at, 0.0, 0.0
        bone.keyframe_insert("location", frame=frame)
    action, path = actor.animation_data.action, bone.path_from_id("location")
    frames = np.arange(5.0, 30.0)
    targets = {key: one for key, one in curve_targets.curve_values(action, frames).items() if key[0] == path}
    before = curves(action)
    curve_targets.lead_through(action, targets, 24.0)
    assert all(np.array_equal(points, before[key]) for key, points in curves(action).items())
    targets[path, 0][1][:] += 0.1
    curve_targets.lead_through(action, targets, 24.0)
    assert len(curves(action)[path, 0]) > len(before[path, 0])
