"""The judge of talk: what it must tell and must not, on motions whose making is known."""

import numpy as np
import pytest
import talking
from s2ag.core.learning.corpus import rocketbox_clips
from s2ag.core.learning.evaluate import classifiers, talk_judge, talk_windows
from s2ag.core.motion import skeleton


@pytest.fixture(scope="module")
def people():
    return {f"kind {kind}": [talking.talk(10 * kind + one, 25) for one in range(2)] for kind in range(3)}


def test_bells_are_counted_with_length_and_peak():
    time = np.arange(60) / 15
    speed = np.where(time % 1 < 0.8, np.sin(np.pi * (time % 1) / 0.8), 0.0)
    found = talk_windows.bells(speed)
    assert len(found) == 4
    assert np.allclose(np.diff(found[:, 1]), 15) and (np.abs(found[:, 2] - found[:, 0] - 12) <= 2).all()
    assert len(talk_windows.bells(0.05 * speed)) == 0


def test_a_dent_does_not_make_two_bells():
    speed = np.array([0, 0.2, 0.6, 1.0, 0.9, 1.1, 0.5, 0.1, 0])
    assert talk_windows.bells(speed).tolist() == [[0, 5, 7]]


def test_windows_do_not_know_the_side_and_rest_is_none():
    motion = talking.talk(1, 20)
    ours, mirrored = talk_windows.cut([motion]), talk_windows.cut([skeleton.mirror(motion)])
    assert np.allclose(ours.features, mirrored.features, atol=1e-4) and np.allclose(ours.velocity, mirrored.velocity, atol=1e-4)
    assert ours.features.shape == (len(ours), len(talk_windows.FEATURES))
    assert len(talk_windows.cut([np.tile(motion[:1], (100, 1, 1))])) == 0


def test_features_do_not_tell_the_pose_of_trunk_and_head():
    motion = talking.talk(2, 20)
    leaning = motion.copy()
    leaning[:, 2] = skeleton.normalize(leaning[:, 2] + [0.0, 0.5, 0.5])
    ours, other = (talk_windows.cut([each]) for each in (motion, leaning))
    row = talk_windows.FEATURES.index("head with arms")
    assert np.allclose(np.delete(ours.features, row, 1), np.delete(other.features, row, 1))


@pytest.mark.parametrize("train", [classifiers.linear, classifiers.forest])
def test_classifiers_learn_what_is_there_and_nothing_from_nothing(train):
    random = np.random.default_rng(0)
    features, answers = random.normal(size=(300, 6)), np.arange(300) % 2 == 0
    told = features + answers[:, None] * np.array([1.5, 0, 0, 0, 0, 0])
    for rows, low, high in ((told, 0.75, 1.0), (features, 0.35, 0.65)):
        score = train(rows[:200], answers[:200])(rows[200:])
        assert low < classifiers.area_under_curve(score[answers[200:]], score[~answers[200:]]) < high


def test_the_forest_learns_what_no_line_divides():
    random = np.random.default_rng(0)
    features = random.uniform(-1, 1, (400, 3))
    answers = features[:, 0] * features[:, 1] > 0
    score = classifiers.forest(features[:300], answers[:300])(features[300:])
    assert classifiers.area_under_curve(score[answers[300:]], score[~answers[300:]]) > 0.8


def test_area_under_curve():
    assert classifiers.area_under_curve(np.array([2.0, 3]), np.array([1.0, 0])) == 1
    assert classifiers.area_under_curve(np.array([1.0, 0]), np.array([1.0, 0])) == 0.5


@pytest.mark.slow
def test_equals_are_not_told_apart_and_others_are(people):
    same = talk_judge.told_apart([talking.talk(100 + one, 30) for one in range(4)], people, draws=1)
    assert abs(same.told - 0.5) < 0.15 and abs(same.told_again - 0.5) < 0.15
    assert abs(same.people_mean - 0.5) < 0.15
    sweeps = [talking.talk(200 + one, 30, bell=1.1, size=0.55) for one in range(4)]
    slow = talk_judge.told_apart(sweeps, people, draws=1, alike=False)
    assert slow.told > 0.85 and slow.told_again > 0.85
    assert slow.tells["bells a second"] < -0.5 < 0.5 < slow.tells["length of bells"]


def test_speed_alone_is_not_told(people):
    """Windows are paired by speed: performances that differ in their share of lively ones are the same to the judge."""
    mixed = [talking.talk(300 + one, 25, size=size) for one, size in enumerate((0.15, 0.25, 0.35, 0.15, 0.25, 0.35))]
    assert talk_judge.told_apart(mixed, people, draws=1, alike=False).told < 0.65


def test_a_recording_is_in_one_half_and_halves_of_one_do_not_overlap():
    several = talk_windows.cut([talking.talk(seed, 10) for seed in range(3)])
    for one, other in talk_judge._halves(several):
        assert len(one) and len(other) and not set(one.recording) & set(other.recording)
    single = talk_windows.cut([talking.talk(1, 30)])
    (one, other), _ = talk_judge._halves(single)
    assert len(one) and len(other) and other.begins.min() - one.begins.max() >= talk_windows.SECONDS
    assert len(one) + len(other) > len(single) - talk_windows.SECONDS / talk_windows.HOP - 1


def test_pairs_are_of_nearly_equal_speed_and_used_once(people):
    windows = talk_windows.cut(people["kind 0"])
    faster = talk_windows.cut([talking.talk(7, 30, size=0.4)])
    mine, others = talk_judge.paired(windows, faster, np.random.default_rng(0))
    assert 0 < len(mine) < len(windows)
    assert np.abs(np.log(mine.speed / others.speed)).max() <= 0.25
    assert len(np.unique(others.velocity.sum((1, 2)))) == len(others)


def test_too_little_is_no_figure(people):
    short = talk_judge.told_apart([talking.talk(1, 4)], people, draws=1, alike=False)
    assert np.isnan(short.told) and not short.tells


def test_noise_is_told_from_captured_talk(shared):
    names = ("m_conversation", "m_gestic_presentation_left_01", "f_gestic_presentation_right_01")
    captured = {n: [rocketbox_clips.load(shared / rocketbox_clips.FOLDER / f"{n}.npz").directions] for n in names}
    random = np.random.default_rng(0)
    shaken = [skeleton.normalize(talking.talk(s, 40)[:1] + random.normal(scale=0.1, size=(600, 9, 3))) for s in range(2)]
    assert talk_judge.told_apart(shaken, captured, draws=1, alike=False).told > 0.95
