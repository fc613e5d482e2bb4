"""Gestures are found where arms make them, with their phases, hands and sizes."""


import numpy as np
import pytest
from s2ag.core.editing import gestures
from s2ag.core.motion import rest, skeleton
from s2ag.core.motion.interpolation import ramp
from s2ag.core.motion.motion import Motion

RAISED = skeleton.normalize(np.array([[-0.5, 0.6, 0.6], [0.1, -0.6, 0.8]], np.float32))
TAKES = 0.6


def swinging(at, side=0, frames=90, words=(), **meta):
    """Arms at rest, of which one (0 left, 1 right; 2 both) goes up in 0.6 s around ``at`` seconds and stays there."""
    time = np.arange(frames) / skeleton.FPS
    share = ramp(time, at - TAKES / 2, at + TAKES / 2)
    directions = np.repeat(skeleton.REST[None], frames, 0).astype(np.float32)
    for arm, mirror in ((0, 1), (1, -1)):
        if side in (arm, 2):
            goal = RAISED * np.array([mirror, 1, 1])
            edges = list(skeleton.ARMS[arm])
            directions[:, edges] = rest.slerp(directions[:, edges], goal, share[:, None])
    return Motion(directions, words=words, meta=meta)


@pytest.mark.parametrize(("side", "hand"), [(0, "left"), (1, "right"), (2, "both")])
@pytest.mark.parametrize("at", [2.0, 2.03, 3.5])
def test_a_swing_is_a_gesture_of_its_hand_at_its_time(side, hand, at):
    motion = swinging(at, side)
    (one,) = gestures.find_gestures(motion)
    assert one.hand == hand
    assert abs(one.at - at) < 0.5 / skeleton.FPS
    way = np.linalg.norm(skeleton.wrists(motion.directions)[[0, -1]][1] - skeleton.wrists(motion.directions)[0], axis=-1)
    assert 0.8 * way.max() < one.size < 1.6 * way.max()  # along an arc, without its slow ends


def test_phases_come_in_order_and_hold_lasts_until_the_end():
    (one,) = gestures.find_gestures(swinging(2.0))
    times = [one.begin, one.stroke, one.at, one.hold, one.release, one.end]
    assert times == sorted(times)
    assert one.begin >= 2.0 - TAKES and one.hold <= 2.0 + TAKES
    assert one.release > 5.0


def test_kind_and_word_are_those_nearby():
    words = (("so", 0.5, 0.8), ("huge", 1.9, 2.3), ("end", 4.0, 4.5))
    (one,) = gestures.find_gestures(swinging(2.0, words=words, shows=[["big", 2.1], ["me", 5.0]]))
    assert (one.word, one.kind) == ("huge", "big")
    (one,) = gestures.find_gestures(swinging(3.0, words=words, shows=["damaged", [1], None]))
    assert (one.word, one.kind) == ("", gestures.BEAT)


def test_still_and_short_motions_have_none():
    still = np.repeat(skeleton.REST[None], 30, 0).astype(np.float32)
    for frames in (1, 2, 3, 30):
        assert gestures.find_gestures(Motion(still[:frames])) == []


def test_the_nearest_is_had_within_reach_only():
    found = gestures.find_gestures(swinging(2.0))
    assert gestures.nearest_of(found, 2.2) is found[0]
    assert gestures.nearest_of(found, 2.5) is None
    assert gestures.nearest_of([], 2.0) is None


@pytest.mark.parametrize("at", [1.0, 2.0, 2.2, 3.4])
def test_the_nearest_one_is_that_of_all(at):
    swings = [swinging(2.0), swinging(3.0, 1)]
    directions = np.where(np.arange(9)[:, None] < 6, *(one.directions for one in swings))
    motion = Motion(directions, words=[("one", 1.9, 2.1), ("two", 2.9, 3.1)])
    assert len(gestures.find_gestures(motion)) == 2
    for within in (0.25, 0.6):
        assert gestures.nearest_gesture(motion, at, within) == gestures.nearest_of(gestures.find_gestures(motion), at, within)
