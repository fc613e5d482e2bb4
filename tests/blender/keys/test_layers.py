"""Gestures beside the animation that is there: nothing of it changes, and what is seen is what was asked for."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from acted import animate, apart, curves, lay, pose, same_curves
from s2ag.core.motion import quaternion, rest
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis import hand_synthesis
from s2ag.s2ag_blender.keys import blending, layers, poses
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import generate


@pytest.fixture
def arm(actor):
    """Name of the bone of the left upper arm."""
    return reading.resolve_mapping(actor, reading.read(actor)).chains["left_upper_arm"][0]


def still(directions, frames=46):
    return Motion(np.repeat(np.asarray(directions, np.float32)[None], frames, 0), meta={"style": "still"})


def raised():
    """Standing at ease with the left arm straight out to the side."""
    pose = rest.REST.copy()
    pose[4] = pose[5] = (-1, 0, 0)
    return pose


def tracks(armature):
    return [[strip.action.name for strip in track.strips] for track in armature.animation_data.nla_tracks]


def test_a_new_action_is_a_copy_of_the_former_with_gestures_in_the_range(actor, arm, wave):
    foot = actor.data.bones[0].name
    walk = animate(actor, [arm, foot], frames=(1, 5, 30, 90, 100))
    before = curves(walk)
    (made,) = lay(actor, wave(46))
    assert same_curves(walk, before) and actor.animation_data.action == made and walk.use_fake_user
    found = curves(made)
    for key, points in before.items():
        if foot in key[0]:
            assert np.array_equal(found[key], points)
        else:
            outside = (points[:, 0] < 10) | (points[:, 0] > found_range(found, key, 83))
            kept = found[key][(found[key][:, 0] < 9) | (found[key][:, 0] > found_range(found, key, 84))]
            np.testing.assert_allclose(kept, points[outside], atol=1e-6)


def found_range(found, key, limit):
    inside = found[key][:, 0]
    return inside[inside <= limit].max()


def test_gestures_blend_in_and_out_of_the_former_action(actor, arm, wave):
    animate(actor, [arm], frames=(1, 120), turn=1.0)
    first, last = pose(actor, 10), pose(actor, 82)
    (made,) = lay(actor, wave(46), blend_in=8, blend_out=8)
    assert layers.Place.of(made).last == 82
    assert apart({arm: first[arm]}, {arm: pose(actor, 10)[arm]}) < 0.1
    assert apart({arm: last[arm]}, {arm: pose(actor, 82)[arm]}) < 0.1
    assert apart({arm: first[arm]}, {arm: pose(actor, 40)[arm]}) > 5


def test_without_animation_there_is_nothing_to_blend_with(actor, arm, wave):
    (made,) = lay(actor, wave(46), blend_in=8)
    (sharp,) = lay(actor, wave(46), blend_in=0)
    assert same_curves(made, sharp)


def test_an_imported_action_of_the_place_alone_is_nothing_to_blend_with(actor, arm, wave):
    (sharp,) = lay(actor, wave(46), blend_in=0)
    actor.animation_data_clear()
    for frame in (1, 2):  # as an FBX's "Take 001" has them
        actor.keyframe_insert("location", frame=frame)
    (made,) = lay(actor, wave(46), blend_in=8, blend_out=8)
    posed = [{key: points for key, points in curves(one).items() if key[0].startswith("pose.")} for one in (sharp, made)]
    assert posed[0] and posed[0].keys() == posed[1].keys()
    assert all(np.array_equal(points, posed[1][key]) for key, points in posed[0].items())


def test_a_strip_covers_the_former_action_and_leaves_it_alone(actor, arm, wave):
    walk = animate(actor, [arm], frames=(1, 200), turn=1.0)
    before = curves(walk)
    plain = {frame: pose(actor, frame) for frame in (5, 10, 120)}
    (made,) = lay(actor, wave(46), result="STRIP", blend_in=4, blend_out=4)
    assert same_curves(walk, before) and actor.animation_data.action is None
    assert tracks(actor) == [["walk"], [made.name]]
    for frame, was in plain.items():
        assert apart(was, pose(actor, frame)) < 0.1, frame
    assert apart(plain[10], pose(actor, 40)) > 5


def test_another_try_on_the_same_frames_takes_the_strip_of_the_first(actor, arm, wave):
    animate(actor, [arm], frames=(1, 200))
    first = lay(actor, wave(46), result="STRIP")[0]
    second = lay(actor, wave(46), result="STRIP")[0]
    assert tracks(actor) == [["walk"], [second.name]]
    actor.s2ag.active_take = 0
    assert tracks(actor) == [["walk"], [first.name]]


def test_a_second_line_gets_a_place_of_its_own(actor, arm, wave):
    first = lay(actor, wave(46), result="STRIP")[0]
    second = lay(actor, wave(46), result="STRIP", start_frame=90)[0]
    overlapping = lay(actor, wave(46), result="STRIP", start_frame=150)[0]
    assert tracks(actor) == [[first.name, second.name], [overlapping.name]]


def test_a_second_line_in_one_action_keeps_the_first(actor, wave):
    (first,) = lay(actor, wave(46))
    (both,) = lay(actor, wave(46), start_frame=100)
    for key, points in curves(first).items():
        found = curves(both)[key]
        np.testing.assert_array_equal(found[found[:, 0] <= 82], points)
        assert (found[:, 0] >= 100).any()
    (again,) = lay(actor, still(raised()), start_frame=100)
    assert again["s2ag_base"] == first


def test_a_layer_adds_to_what_is_below_it(actor, arm):
    """At full influence Blender shows base after the change from the neutral pose: ``base * (neutral^-1 * gesture)``."""
    animate(actor, [arm], frames=(1, 200), turn=1.0)
    bpy.context.scene.frame_set(40)
    below = poses.current_rotations(actor, [arm])[arm]
    (made,) = lay(actor, still(raised()), result="LAYER", blend_in=0, blend_out=0, curves="FRAMES")
    strip = actor.animation_data.nla_tracks[-1].strips[0]
    assert (strip.action, strip.blend_type, strip.use_animated_influence) == (made, "COMBINE", True)
    bpy.context.scene.frame_set(40)
    seen = poses.current_rotations(actor.evaluated_get(bpy.context.evaluated_depsgraph_get()), [arm])[arm]
    keys = [curves(made)[f'pose.bones["{arm}"].rotation_quaternion', index][20, 1] for index in range(4)]
    wanted = quaternion.multiply(below, np.array(keys))
    assert abs(abs(seen @ wanted) - 1) < 1e-5
    assert abs(seen @ seen - 1) < 1e-4


def test_a_layer_at_half_influence_goes_half_way(actor, arm):
    rest_pose = pose(actor, 40)
    lay(actor, still(raised()), result="LAYER", blend_in=0, blend_out=0)
    full = pose(actor, 40)
    lay(actor, still(raised()), influence=0.5)
    half = pose(actor, 40)
    whole = apart({arm: rest_pose[arm]}, {arm: full[arm]})
    assert apart({arm: rest_pose[arm]}, {arm: half[arm]}) == pytest.approx(whole / 2, abs=1) and whole > 20


def test_a_layer_in_the_neutral_pose_is_the_gesture(actor, arm):
    lay(actor, still(rest.REST))
    lay(actor, still(raised()))
    wanted = pose(actor, 40)
    actor.animation_data.action = None
    base = lay(actor, still(rest.REST, 100), start_frame=1)[0]
    base["s2ag"] = "{}"  # as if it were the user's
    lay(actor, still(raised()), result="LAYER", start_frame=10, blend_in=0, blend_out=0)
    assert apart(wanted, pose(actor, 40)) < 0.2


def test_hands_of_a_layer_depart_from_hands_at_ease(actor):
    def laid(directions):
        motion = still(directions)
        (made,) = lay(
            actor, replace(motion, hands=hand_synthesis.hanging_hands(motion.directions)), result="LAYER", curves="FRAMES"
        )
        return np.array([curves(made)[f'pose.bones["{hand}"].rotation_quaternion', index][20, 1] for index in range(4)])

    hand = reading.resolve_mapping(actor, reading.read(actor)).chains["left_hand"][0]
    np.testing.assert_allclose(laid(rest.REST), [1, 0, 0, 0], atol=0.05)  # breathing is added
    assert abs(laid(raised())[0]) < np.cos(np.radians(5))


def test_a_layer_fades_in_and_out_by_keyed_influence(actor, arm):
    animate(actor, [arm], frames=(1, 200), turn=1.0)
    plain = {frame: pose(actor, frame) for frame in (10, 82, 90)}
    lay(actor, still(raised()), result="LAYER", blend_in=8, blend_out=8)
    for frame, was in plain.items():
        assert apart(was, pose(actor, frame)) < 0.5, frame
    assert apart(plain[10], pose(actor, 40)) > 20


def test_a_layer_on_bones_that_turn_by_angles_is_told_and_exact_over_the_neutral_pose(actor, arm):
    actor.pose.bones[arm].rotation_mode = "XYZ"
    lay(actor, still(raised()))
    wanted = pose(actor, 40)
    actor.animation_data.action = None
    base = lay(actor, still(rest.REST, 100), start_frame=1)[0]
    base["s2ag"] = "{}"
    actor.s2ag.result, actor.s2ag.start_frame, actor.s2ag.blend_in, actor.s2ag.blend_out = "LAYER", 10, 0, 0
    outcome = generate.finish(generate.plan(bpy.context, actor), {"motions": [still(raised())]})
    assert any("angles" in warning for warning in outcome.warnings)
    assert apart(wanted, pose(actor, 40)) < 0.2
    assert actor.pose.bones[arm].rotation_mode == "XYZ"


def test_continue_from_this_pose(actor, arm, wave):
    actor.pose.bones[arm].rotation_quaternion = (0.8, 0.6, 0, 0)
    bpy.context.view_layer.update()
    now = {arm: np.array(actor.pose.bones[arm].matrix)}
    actor.s2ag.start_pose = "CURRENT"
    planned = generate.plan(bpy.context, actor)
    seed = np.array(planned.params["pose"])
    assert seed.shape == (9, 3)
    np.testing.assert_allclose(np.linalg.norm(seed, axis=1), 1, atol=1e-5)
    actor.pose.bones[arm].rotation_quaternion = (1, 0, 0, 0)  # the pose of the press counts
    generate.finish(planned, {"motions": [wave(46)]})
    assert apart(now, {arm: pose(actor, 10)[arm]}) < 0.5
    assert apart(now, {arm: pose(actor, 40)[arm]}) > 5


@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
@pytest.mark.parametrize("end", ["CURRENT", "THERE"])
def test_reach_a_pose_at_the_end(actor, arm, wave, result, end):
    animate(actor, [arm], frames=(1, 200), turn=2.0)
    wanted = pose(actor, 82 if end == "THERE" else 150)
    bpy.context.scene.frame_set(150)
    lay(actor, wave(46), result=result, end_pose=end)
    assert apart({arm: wanted[arm]}, {arm: pose(actor, 82)[arm]}) < 0.5
    assert apart({arm: wanted[arm]}, {arm: pose(actor, 50)[arm]}) > 5


def test_pushing_down_keeps_how_the_action_was_played(actor, arm, wave):
    walk = animate(actor, [arm], frames=(5, 60))
    actor.animation_data.action_extrapolation = "NOTHING"
    lay(actor, wave(46), result="STRIP")
    strip = actor.animation_data.nla_tracks[0].strips[0]
    assert (strip.action, strip.extrapolation, strip.frame_start, strip.frame_end) == (walk, "NOTHING", 5, 60)


def test_an_unkeyed_character_holds_its_strip(actor, wave):
    (made,) = lay(actor, wave(46), result="STRIP")
    strip = actor.animation_data.nla_tracks[0].strips[0]
    assert strip.extrapolation == "HOLD" and strip.blend_in == strip.blend_out == 0
    layers.hide(actor, made)
    assert not actor.animation_data.nla_tracks


def test_ramps_and_mixing():
    frames = np.arange(10, 31)
    up, down = blending.ramp(frames, 5), blending.ramp(frames, 5, at_end=True)
    assert up[0] == 0 and up[5] == up[-1] == 1 and (np.diff(up) >= 0).all()
    np.testing.assert_array_equal(down, up[::-1])
    assert (blending.ramp(frames, 0) == 1).all()
    turned = np.array([np.cos(0.5), np.sin(0.5), 0, 0])
    mixed = blending.mix({"bone": np.tile(turned, (21, 1))}, {"bone": quaternion.IDENTITY}, up)["bone"]
    np.testing.assert_allclose(mixed[0], quaternion.IDENTITY, atol=1e-9)
    np.testing.assert_allclose(mixed[-1], turned, atol=1e-9)
