"""Ways that joins take: as near to what they were as the take's own speed and acceleration let them."""

import numpy as np
import pytest
from s2ag.core.editing import regeneration, transitions
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion

FRAMES = 90


@pytest.fixture
def take():
    """Arms that swing to and fro."""
    directions = np.tile(skeleton.MEAN_UNIT, (FRAMES, 1, 1)).astype(float)
    swing = 0.5 * np.sin(2 * np.pi * np.arange(FRAMES) / 12)
    directions[:, [5, 8], 2] += swing[:, None]
    return Motion(skeleton.normalize(directions).astype(np.float32), skeleton.FPS)


def jumped(take, first, last, by=0.1):
    """The take with one arm elsewhere from frame to frame, without a way to there and back."""
    directions = take.directions.copy()
    directions[first:last, 4:6] = skeleton.normalize(directions[first:last, 4:6] + [0.0, -by, by])
    return Motion(directions, take.fps)


def test_a_join_is_as_gentle_as_the_take_and_what_is_kept_stays(take):
    made, kept, place = jumped(take, 40, 48), np.zeros(FRAMES, bool), [(30, 58)]
    kept[42:46] = True
    assert regeneration.speed_excess(take, made, place) > 0.5
    soft, left = transitions.ease_joins(take, made, place, kept)
    assert left == 0 and regeneration.speed_excess(take, soft, [(0, FRAMES)]) == 0
    same = kept | (np.arange(FRAMES) < 30) | (np.arange(FRAMES) >= 58)
    assert np.array_equal(soft.directions[same], made.directions[same])
    assert np.array_equal(soft.directions[:, :3], made.directions[:, :3])


def test_a_join_reaches_beyond_a_span_that_is_too_short(take):
    made, kept = jumped(take, 40, 48, 0.15), np.zeros(FRAMES, bool)
    kept[40:48] = True
    soft, left = transitions.ease_joins(take, made, [(39, 49)], kept)
    rows = np.flatnonzero((soft.directions != made.directions).any((1, 2)))
    assert left == 0 and regeneration.speed_excess(take, soft, [(0, FRAMES)]) == 0 < regeneration.speed_excess(
        take, made, [(0, FRAMES)]
    )
    assert rows[0] < 39 and rows[-1] >= 49 and not kept[rows].any()


def test_what_is_gentle_already_stays(take):
    soft, left = transitions.ease_joins(take, take, [(30, 60)], np.zeros(FRAMES, bool))
    assert soft is take and left == 0
