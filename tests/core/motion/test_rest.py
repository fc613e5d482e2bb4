import numpy as np
import pytest
from s2ag.core.motion import rest, skeleton

FPS = skeleton.FPS


def gesture(frames):
    """A performance far from rest: forearms raised and waving."""
    time = np.arange(frames) / FPS
    directions = np.tile(skeleton.MEAN_UNIT, (frames, 1, 1))
    directions[:, 5] = np.stack([0.3 * np.sin(6 * time), -0.5 + 0.3 * np.cos(5 * time), np.ones(frames)], -1)
    return skeleton.normalize(directions).astype(np.float32)


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def test_hands_come_to_rest_in_a_long_silence_and_are_back_before_speech():
    frames = 300
    activity = np.ones(frames)
    activity[100:220] = 0
    performed = rest.RestBlend.of(activity).live(gesture(frames))
    resting = slice(100 + int((rest.SETTLE_AFTER + rest.SETTLE_TIME) * FPS) + 1, 220 - int(rest.RAISE_TIME * FPS) - 1)
    assert angles(performed[resting], rest.REST).max() < 6
    assert angles(performed[90, 5], rest.REST[5]) > 40
    assert angles(performed[222], gesture(frames)[222]).max() < 6


def test_short_pauses_are_left_to_the_network():
    activity = np.ones(200)
    activity[100 : 100 + int(rest.SETTLE_AFTER * FPS)] = 0
    assert rest.settle_weight(activity)[10:].max() == 0 == rest.settle_weight(activity, at_rest=False).max()


def test_settling_is_smooth():
    activity = np.ones(300)
    activity[50:150] = 0
    weight = rest.settle_weight(activity)
    assert weight[10:50].max() == weight[150:].max() == 0 and weight.max() == 1
    assert np.abs(np.diff(weight, 2)).max() < 0.12


@pytest.mark.parametrize("silence", [0, 3, 7, 20])
def test_speech_leaves_rest_without_a_jump_even_from_the_first_frame(silence):
    weight = rest.settle_weight(np.arange(60) >= silence)
    assert weight[0] == 1 and weight[max(silence, int(rest.RAISE_TIME * FPS)) + 1 :].max() == 0
    assert -np.diff(weight).min() < 0.26 and weight[1] > 0.97


def test_a_silent_clip_rests_from_the_first_frame_to_the_last_yet_no_frame_is_frozen():
    performed = rest.RestBlend.of(np.zeros(450)).live(gesture(450))
    assert angles(performed, rest.REST).max() < 6
    speed = angles(performed[1:], performed[:-1]).max(1) * FPS
    assert speed.min() > 0.05


def test_idle_depends_on_the_seed_alone():
    assert np.array_equal(rest.idle_offsets(60, seed=3), rest.idle_offsets(60, seed=3))
    assert not np.allclose(rest.idle_offsets(60, seed=3), rest.idle_offsets(60, seed=4))


def test_intensity_scales_the_departure_from_rest():
    directions = gesture(20)
    np.testing.assert_allclose(rest.scale_amplitude(directions, 0), np.broadcast_to(rest.REST, directions.shape), atol=1e-6)
    assert rest.scale_amplitude(directions, 1) is directions
    half, more = (angles(rest.scale_amplitude(directions, x), rest.REST)[:, 5] for x in (0.5, 1.3))
    full = angles(directions, rest.REST)[:, 5]
    np.testing.assert_allclose(half, full / 2, atol=0.05)
    np.testing.assert_allclose(more, np.minimum(full * 1.3, 170), atol=0.05)


def test_slerp_survives_equal_and_opposite_vectors():
    up = np.array([0.0, 1.0, 0.0])
    assert np.isfinite(rest.slerp(up, up, np.array(0.5))).all()
    assert np.isfinite(rest.slerp(up, -up, np.array(0.5))).all()


def test_softening_takes_tremble_and_leaves_gestures():
    turned = gesture(90)
    shaken = skeleton.normalize(turned + 0.05 * (-1.0) ** np.arange(90)[:, None, None] * np.array([1.0, 0, 0]))
    between = skeleton.normalize(turned[:-2] + turned[2:])
    moved = angles(rest.remove_jitter(turned), turned)[1:-1]
    assert (moved <= 0.5 * angles(between, turned[1:-1]) + 0.1).all() and moved.mean() < 0.2
    assert angles(rest.remove_jitter(shaken), turned)[1:-1].mean() < 0.3 * angles(shaken, turned).mean()


def test_arms_that_hardly_move_are_held_and_others_and_given_frames_stay():
    time = np.arange(120) / skeleton.FPS
    drawn = np.tile(rest.REST, (120, 1, 1)).astype(np.float32)
    left, right = map(list, skeleton.ARMS)
    drawn[:, left] = skeleton.rotate_about_axis(drawn[:, left], 0, 1.5 * np.sin(2 * np.pi * 1.2 * time))  # wavers
    drawn[:, right] = skeleton.rotate_about_axis(drawn[:, right], 0, 20 * np.sin(2 * np.pi * 1.2 * time))  # beats
    held = rest.hold_still(drawn, [30])
    ways = [[angles(each[50:70, arm], drawn[:1, arm]).max() for each in (held, drawn)] for arm in (left, right)]
    moved = [after / before for after, before in ways]
    assert moved[0] < 0.5 and moved[1] > 0.99
    np.testing.assert_allclose(held[30], drawn[30], atol=1e-6)
    np.testing.assert_array_equal(rest.hold_still(drawn[:1]), drawn[:1])


@pytest.mark.parametrize("away", [1e-6, 1e-5, 1e-4, 2e-4, 1e-3, 0.1, 2.0])
def test_near_directions_are_told_apart_as_finely_as_far_ones(away):
    """What rounding changes stays as small as it was: an arc cosine of float32 made 0.0003 of it."""
    chance = np.random.default_rng(0)
    start = skeleton.normalize(chance.normal(size=(1000, 3)))
    side = skeleton.normalize(np.cross(start, chance.normal(size=(1000, 3))))
    end = (np.cos(away) * start + np.sin(away) * side).astype(np.float32)
    start = start.astype(np.float32)
    rounding = 8 * float(np.finfo(np.float32).eps)  # of two vectors, their product, their difference and its length
    np.testing.assert_allclose(rest.angle_between(start, end), away, rtol=rounding, atol=rounding)
    np.testing.assert_allclose(rest.slerp(start, end, 1.0), end, atol=rounding)
    half = rest.angle_between(start, rest.slerp(start, end, np.full(1000, 0.5)))
    np.testing.assert_allclose(half, 0.5 * away, rtol=rounding, atol=rounding)


def tilts(motion):
    """Degrees by which necks tilt ahead."""
    return np.degrees(np.arctan2(motion[:, 1, 2], -motion[:, 1, 1]))


def bowed(degrees):
    """Somebody at rest whose neck tilts ahead by ``degrees`` ``(frames,)``."""
    pose = np.repeat(rest.REST[None].astype(np.float32), len(degrees), axis=0)
    pose[:, 1] = np.stack([0 * degrees, -np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], axis=1)
    return pose


def test_a_head_that_hangs_is_raised_with_its_nods_and_others_stay():
    time = np.arange(150) / FPS
    nods = 5 * np.sin(2 * np.pi * 1.5 * time)
    made = rest.raise_head(pose := bowed(60 + nods))
    assert tilts(made).mean() == pytest.approx(60 - 26**2 / (26 + 8), abs=0.5) and tilts(made).max() < 34 + 8 + 6
    np.testing.assert_allclose((tilts(made) - tilts(made).mean())[30:-30], nods[30:-30], atol=0.7)
    turned = angles(made[:, [1, 2]], pose[:, [1, 2]])
    np.testing.assert_allclose(turned[:, 0], turned[:, 1], atol=0.1)  # the head goes with its neck
    np.testing.assert_array_equal(np.delete(made, [1, 2], axis=1), np.delete(pose, [1, 2], axis=1))
    np.testing.assert_array_equal(rest.raise_head(bowed(27 + nods)), bowed(27 + nods))
    brief = bowed(np.where(np.abs(time - 5) < 0.3, 50.0, 25.0))
    np.testing.assert_array_equal(rest.raise_head(brief), brief)  # somebody looks down for a moment
