import numpy as np
import pytest
from reaching import reaching
from refining import apply
from s2ag.core.motion import limits, rest, skeleton
from s2ag.core.synthesis.refine import refine
from s2ag.core.synthesis.refine.reach_limit import (
    ahead_limit,
    both_aside,
    brief_heights,
    hanging_aside,
    high_hands,
    reach_limit,
)


def beyond(pose: np.ndarray, side: int) -> float:
    """Metres of a wrist beyond the body's middle."""
    wrist = skeleton.to_positions(pose)[0, skeleton.EDGES[skeleton.ARMS[side][1]][1]]
    return float(wrist[0]) * (-1 if side else 1)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("height", [-0.1, 0.1])
def test_a_wrist_at_the_other_shoulder_comes_back(side, height):
    pose = reaching(side, height, 0.2)
    assert beyond(pose, side) == pytest.approx(0.2, abs=1e-3)
    made = apply(reach_limit, pose)
    assert 0.05 < beyond(made, side) < 0.1
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[side]]
    np.testing.assert_array_equal(made[:, others], pose[:, others])


@pytest.mark.parametrize("side", [0, 1])
def test_what_is_before_the_body_or_low_stays(side):
    for pose in (reaching(side, 0.0, 0.04), reaching(side, -0.46, 0.15), rest.REST[None].astype(np.float32)):
        np.testing.assert_allclose(apply(reach_limit, pose), pose, atol=1e-6)


def both(height: float, aside: float) -> np.ndarray:
    """A pose (1, 9, 3) of two wrists so far (m) beyond the body's middle."""
    pose, right = reaching(0, height, aside), list(skeleton.ARMS[1])
    pose[:, right] = reaching(1, height, aside)[:, right]
    return pose


@pytest.mark.parametrize("height", [-0.2, 0.0, 0.1])
def test_hands_that_cross_part_and_those_side_by_side_stay(height):
    for aside in (0.02, 0.05, 0.09):
        made = apply(reach_limit, both(height, aside))
        assert sum(beyond(made, side) for side in (0, 1)) < 0.03
    apart = both(height, -0.08)
    np.testing.assert_allclose(apply(reach_limit, apart), apart, atol=1e-6)
    low = both(-0.46, 0.05)
    np.testing.assert_allclose(apply(reach_limit, low), low, atol=1e-6)


def test_hands_part_smoothly_and_alike():
    places = np.array([[beyond(apply(reach_limit, both(-0.1, aside)), side) for side in (0, 1)]
                       for aside in np.arange(-0.15, 0.1, 0.005)])  # fmt: skip
    steps = np.diff(places, axis=0)
    np.testing.assert_allclose(places[:, 0], places[:, 1], atol=0.003)  # the mean skeleton is no mirror image
    assert steps.min() > -1e-3 and steps.max() < 0.0056 and np.abs(np.diff(steps, axis=0)).max() < 0.25 * 0.005


def test_given_frames_stay_and_the_ways_to_them_are_smooth():
    still = np.repeat(reaching(1, 0.0, 0.2), 60, axis=0)
    made = apply(reach_limit, still, np.array([30, 31]))
    np.testing.assert_allclose(made[30:32], still[30:32], atol=1e-6)
    np.testing.assert_allclose(made[[0, 59]], apply(reach_limit, still)[[0, 59]], atol=1e-6)
    assert np.abs(np.diff(made, axis=0)).max() < 0.06


def test_it_sets_in_smoothly():
    places = [beyond(apply(reach_limit, reaching(1, -0.05, aside)), 1) for aside in np.arange(0.0, 0.25, 0.005)]
    steps = np.diff(places)
    assert (steps > 0).all() and steps.max() < 0.0056 and np.abs(np.diff(steps)).max() < 0.25 * 0.005


def stretched(side: int, heading: float, lift: float = 0.0) -> np.ndarray:
    """A pose (1, 9, 3) with one straight arm: degrees from straight ahead to the side, and above the shoulder."""
    pose = rest.REST.astype(float).copy()[None]
    turn, up = np.radians(heading), np.radians(lift)
    out = 1.0 if side else -1.0
    pose[0, list(skeleton.ARMS[side])] = [out * np.cos(up) * np.sin(turn), -np.sin(up), np.cos(up) * np.cos(turn)]
    return pose.astype(np.float32)


def wide(pose: np.ndarray, side: int) -> float:
    """Metres of a wrist away from its own shoulder, to its side."""
    points, (upper, lower) = skeleton.to_positions(pose)[0], skeleton.ARMS[side]
    return float(points[skeleton.EDGES[lower][1], 0] - points[skeleton.EDGES[upper][0], 0]) * (1 if side else -1)


@pytest.mark.parametrize("side", [0, 1])
def test_an_arm_straight_out_to_the_side_is_brought_forward(side):
    for lift in (0, 20):
        pose = stretched(side, 84, lift)
        made = apply(reach_limit, pose)
        assert wide(pose, side) > 0.5 and 0.4 < wide(made, side) < 0.5
        assert (made[0, list(skeleton.ARMS[side]), 2] > 0.4).all()
    low = stretched(side, 84, -65)
    np.testing.assert_allclose(apply(reach_limit, low), low, atol=1e-6)


@pytest.mark.parametrize("lift", [-40, -20, 0])
def test_arms_held_out_come_in_and_one_alone_stays_where_it_points(lift):
    pose, right = stretched(0, 60, lift), list(skeleton.ARMS[1])
    pose[:, right] = stretched(1, 60, lift)[:, right]
    made = apply(both_aside, pose)
    for side in (0, 1):
        assert wide(pose, side) > 0.4 and 0.08 < wide(made, side) < 0.18
    one = stretched(0, 60, lift)
    np.testing.assert_array_equal(apply(both_aside, one), one)


def test_arms_held_out_beat_as_far_as_before():
    swings = 50 + 6 * np.sin(2 * np.pi * 1.5 * np.arange(90) / skeleton.FPS)
    beats = np.concatenate([stretched(0, heading, -20) for heading in swings])
    right = list(skeleton.ARMS[1])
    beats[:, right] = np.concatenate([stretched(1, heading, -20)[:, right] for heading in swings])
    before, after = (np.array([wide(one[None], 1) for one in each[30:60]]) for each in (beats, apply(both_aside, beats)))
    assert np.mean(before) - np.mean(after) > 0.1 and np.ptp(after) > 0.9 * np.ptp(before)


@pytest.mark.parametrize("side", [0, 1])
def test_hands_that_are_held_up_come_down_and_beat_as_far_as_before(side):
    lifts = 10 + 6 * np.sin(2 * np.pi * 1.5 * np.arange(90) / skeleton.FPS)
    beats = np.concatenate([stretched(side, 20, lift) for lift in lifts])
    wrist, shoulder = (skeleton.EDGES[edge][end] for edge, end in zip(skeleton.ARMS[side][::-1], (1, 0), strict=True))
    made = apply(high_hands, beats)
    before, after = (points[30:60, wrist] - points[30:60, shoulder] for points in map(skeleton.to_positions, (beats, made)))
    assert before[:, 1].mean() < 0 and 0.05 < after[:, 1].mean() < 0.15  # y is down
    assert np.ptp(after[:, 1]) > 0.9 * np.ptp(before[:, 1])
    low = stretched(side, 20, -60)
    np.testing.assert_array_equal(apply(high_hands, low), low)


@pytest.mark.parametrize("side", [0, 1])
def test_an_arm_that_hangs_away_from_the_body_comes_in_at_the_height_of_its_hand(side):
    pose = stretched(side, 90, -65)
    before, after = (skeleton.to_positions(each)[0] for each in (pose, apply(hanging_aside, pose)))
    shoulder, wrist = (skeleton.EDGES[edge][end] for edge, end in zip(skeleton.ARMS[side], (0, 1), strict=True))
    far = [abs(each[wrist, 0] - each[shoulder, 0]) for each in (before, after)]
    assert far[0] > 0.26 and 0.13 < far[1] < 0.22 and abs(after[wrist, 1] - before[wrist, 1]) < 0.06
    assert not limits.backward_elbows(apply(hanging_aside, pose)).any()
    for near in (stretched(side, 90, -85), stretched(side, 90, -20)):
        np.testing.assert_array_equal(apply(hanging_aside, near), near)


@pytest.mark.parametrize("side", [0, 1])
def test_a_hand_that_is_flicked_up_or_let_fall_goes_less_far_and_beats_stay(side):
    wrist = skeleton.EDGES[skeleton.ARMS[side][1]][1]

    def heights(lifts):
        poses = np.concatenate([stretched(side, 20, lift) for lift in lifts])
        return (-skeleton.to_positions(each)[:, wrist, 1] for each in (poses, apply(brief_heights, poses)))

    time = np.arange(90) / skeleton.FPS
    for sign in (1, -1):
        brief, long = (sign * 30 * np.exp(-0.5 * ((time - 3) / wide) ** 2) - 35 for wide in (0.15, 0.8))
        before, after = heights(brief)
        assert np.ptp(before) > 0.2 and np.ptp(after) < 0.8 * np.ptp(before)
        before, after = heights(long)
        assert np.ptp(before) > 0.2 and np.ptp(after) > 0.9 * np.ptp(before)
    before, after = heights(4 * np.sin(2 * np.pi * 1.5 * time) - 35)
    np.testing.assert_allclose(after, before, atol=1e-3)


def test_arms_open_smoothly():
    places = np.array([wide(apply(reach_limit, stretched(1, heading)), 1) for heading in range(0, 86)])
    assert (np.diff(places) > -1e-6).all() and np.diff(places).max() < 0.0125 and np.abs(np.diff(places, 2)).max() < 0.002


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("lift", [-40, -20, 0, 20])
def test_an_arm_stretched_ahead_bends_at_the_height_of_its_hand(side, lift):
    pose = stretched(side, 0, lift)
    before, after = (skeleton.to_positions(each)[0] for each in (pose, apply(ahead_limit, pose)))
    upper, lower = skeleton.ARMS[side]
    (shoulder, elbow), wrist = skeleton.EDGES[upper], skeleton.EDGES[lower][1]
    assert before[wrist, 2] - before[shoulder, 2] > 0.5 and 0.4 < after[wrist, 2] - after[shoulder, 2] < 0.54
    assert after[elbow, 1] > before[elbow, 1] + 0.03  # y is down
    np.testing.assert_allclose(after[wrist, :2], before[wrist, :2], atol=0.03)  # ahead of a trunk that leans
    assert not limits.backward_elbows(apply(ahead_limit, pose)).any()


def test_hands_before_the_belly_stay_and_arms_bend_smoothly():
    near = reaching(1, -0.2, -0.1)
    np.testing.assert_array_equal(apply(ahead_limit, near), near)
    lifts = np.concatenate([apply(ahead_limit, stretched(1, 0, lift)) for lift in np.arange(-70.0, 0.0, 0.5)])
    wrists = skeleton.to_positions(lifts)[:, skeleton.EDGES[skeleton.ARMS[1][1]][1]]
    steps = np.linalg.norm(np.diff(wrists, axis=0), axis=-1)
    assert steps.max() < 0.0075 and np.abs(np.diff(steps)).max() < 0.001  # half a degree of 0.69 m is 0.006 m


def test_an_arm_behind_that_is_led_to_the_front_is_not_stretched_there():
    """Round the side to the front, as a refined performance has it: neither far ahead nor a wing."""
    aside = np.repeat(stretched(1, 110, -5), 60, axis=0)
    points = skeleton.to_positions(refine(aside))
    upper, lower = skeleton.ARMS[1]
    shoulder, elbow = skeleton.EDGES[upper]
    assert (points[:, skeleton.EDGES[lower][1], 2] - points[:, shoulder, 2] < 0.56).all()
    assert (points[:, elbow, 1] - points[:, shoulder, 1] > 0.1).all()
