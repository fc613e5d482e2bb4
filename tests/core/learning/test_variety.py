"""Figures of variety on motions whose answers are known."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import rotation
from s2ag.core.learning.evaluate import kinematics, variety
from s2ag.core.motion import rest, skeleton


def waving(frames: int, ways: np.ndarray, period: int = 30) -> np.ndarray:
    """Arms that rise and fall once a period ``(frames, 9, 3)``: the k-th time turned by ``ways[k]`` (radians, ``(2, 3)``)."""
    body = np.tile(rest.REST.astype(float), (frames, 1, 1))
    for k, way in enumerate(ways):
        here = slice(k * period, (k + 1) * period)
        lift = np.sin(np.pi * np.arange(period) / period) ** 2
        for arm, edges in enumerate(((4, 5), (7, 8))):
            turns = rotation.from_vector(lift[: len(body[here]), None] * way[arm])
            for edge in edges:
                body[here, edge] = rotation.rotate(turns, body[here, edge])
    return body


@pytest.fixture(scope="module")
def same() -> np.ndarray:
    return waving(900, np.tile([[1.2, 0, 0], [1.2, 0, 0.0]], (30, 1, 1)))


@pytest.fixture(scope="module")
def varied() -> np.ndarray:
    random = np.random.default_rng(0)
    return waving(900, random.normal(0, 0.8, (30, 2, 3)) + [1.0, 0, 0])


def test_peaks_are_high_prominent_and_apart():
    values = np.zeros(60)
    values[[10, 13, 30, 40]] = [1.0, 0.9, 0.2, 0.5]
    values[41:50] = np.linspace(0.49, 0.4, 9)
    values[45] = 0.5
    assert variety.peaks(values, 0.25, 0.15, 6).tolist() == [10, 40]


def test_one_gesture_again_and_again_has_no_neighbours_unlike_it(same, varied):
    assert variety.nearest_neighbour(same) < 0.05 < 0.4 < variety.nearest_neighbour(varied)
    assert variety.first_axis(same) > 0.9 > 0.8 > variety.first_axis(varied)
    assert variety.components(same) <= 2 < variety.components(varied)
    assert variety.cells(varied) > 3 * variety.cells(same)
    assert np.isnan(variety.nearest_neighbour(same[:20]))


def test_a_repeated_stroke_is_told_from_new_ones(same, varied):
    assert variety.most_repeated(same) > 0.9 > 0.4 > variety.most_repeated(varied)
    assert np.isnan(variety.most_repeated(same[:20]))


def test_strokes_of_several_recordings_are_compared_with_each_other(same, varied):
    assert variety.nearest_neighbour(varied[:450], varied[450:]) == pytest.approx(variety.nearest_neighbour(varied), abs=0.1)
    assert variety.nearest_neighbour(varied[:105], varied[:105]) < 0.1 < variety.nearest_neighbour(varied[:105])
    assert np.isnan(variety.nearest_neighbour(np.tile(rest.REST, (90, 1, 1)), same[:20]))


def test_arms_in_step_correlate(same, varied):
    assert variety.left_right_correlation(same) == pytest.approx(1, abs=1e-6)
    assert variety.left_right_correlation(varied) < 0.95


def test_two_performances_are_compared_in_place_and_pose(same, varied):
    assert variety.arms_apart(same, same) == 0 and variety.shared_stroke_places(same, same) == 1
    assert variety.arms_apart(same, varied) > 10
    later = np.concatenate([same[:8], same[:-8]])
    assert variety.shared_stroke_places(same, later) < 0.1
    assert np.isnan(variety.shared_stroke_places(same, np.tile(rest.REST, (900, 1, 1))))
    assert 0.2 < variety.shared_places_by_chance(same, same) < 0.6  # a stroke a second, 0.4 s of which count


def test_a_body_that_turns_has_a_turning_shoulder_line():
    angle = np.radians(10) * np.sin(2 * np.pi * np.arange(300) / 75)
    body = rotation.rotate(rotation.about(1, angle)[:, None], np.tile(rest.REST.astype(float), (300, 1, 1)))
    assert variety.shoulder_yaw(body) == pytest.approx(10 / np.sqrt(2), rel=0.05)


def test_a_voice_is_followed_or_not(varied):
    level = variety.wrist_speed(varied).max(axis=1)
    figures = variety.measure(varied, level)
    assert figures["follows voice"] == pytest.approx(1)
    assert variety.loudness_correlation(varied, np.roll(level, 400)) < 0.9
    assert figures["forearm median"] == pytest.approx(np.median(kinematics.angular_speed(varied)[:, kinematics.FOREARMS]))
    assert all(np.isfinite(value) for value in figures.values()) and skeleton.FPS == 15
