"""Arms that are faster than people's: slowed, in time, and nothing else touched."""

import numpy as np
import pytest
from refining import apply
from s2ag.core.motion import rest, skeleton
from s2ag.core.synthesis import constraints
from s2ag.core.synthesis.refine.speed_limit import speed_limit

FRAMES, AT = 90, 45
TIME = (np.arange(FRAMES) - AT) / skeleton.FPS


def thrown(seconds: float) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` of standing whose left arm is raised by 120 degrees in about so many seconds, and stays."""
    motion = np.tile(rest.REST.astype(float), (FRAMES, 1, 1))
    up = skeleton.normalize(np.array([0.5, -0.7, 0.5]))
    share = 0.5 + 0.5 * np.tanh(2 * TIME / seconds)
    for edge in skeleton.ARMS[0]:
        motion[:, edge] = rest.slerp(motion[:, edge], np.broadcast_to(up, (FRAMES, 3)), share)
    return motion.astype(np.float32)


def speeds(motion: np.ndarray) -> np.ndarray:
    """Metres a second of the left wrist ``(frames,)``."""
    return np.linalg.norm(np.gradient(skeleton.wrists(motion)[:, 0], axis=0), axis=-1) * skeleton.FPS


def test_what_is_too_fast_is_slower_and_as_far():
    drawn = thrown(0.1)
    made = apply(speed_limit, drawn, passes=3)
    assert speeds(drawn).max() > 4 and speeds(made).max() < 0.8 * speeds(drawn).max()
    assert abs(int(speeds(made).argmax()) - AT) <= 1
    assert np.linalg.norm(skeleton.wrists(made)[-1] - skeleton.wrists(drawn)[-1]) == 0
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[0]]
    np.testing.assert_array_equal(made[:, others], drawn[:, others])
    np.testing.assert_array_equal(made[[0, 20, 70]], drawn[[0, 20, 70]])
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(skeleton.mirror(apply(speed_limit, skeleton.mirror(drawn), passes=3)), made, atol=1e-6)


@pytest.mark.parametrize("seconds", [0.6, 2.0])
def test_what_people_do_stays_to_the_bit(seconds):
    drawn = thrown(seconds)
    assert speeds(drawn).max() < 2.7
    np.testing.assert_array_equal(apply(speed_limit, drawn, passes=3), drawn)
    np.testing.assert_array_equal(apply(speed_limit, drawn[:2], passes=3), drawn[:2])


def test_given_frames_stay_and_those_beside_them_nearly():
    drawn, given = thrown(0.1), np.array([AT, AT + 1])
    made = apply(speed_limit, drawn, given, passes=3)
    np.testing.assert_array_equal(made[given], drawn[given])
    moved = np.linalg.norm(made - drawn, axis=-1).max(axis=1)
    assert moved[AT - 1] < 0.2 * (1 - constraints.freedom(FRAMES, given)[AT - 1]) and moved.max() > 0
