import numpy as np
import pytest
from refining import apply
from s2ag.core.motion import limits, rest, skeleton
from s2ag.core.synthesis.refine.midline_dwell import midline_dwell

FPS = skeleton.FPS


def laid(side: int) -> np.ndarray:
    """An arm (2, 3) whose forearm lies before the belly, its hand on the other side."""
    out = 1.0 if side else -1.0
    return skeleton.normalize(np.array([[0.15 * out, 0.9, 0.35], [-0.9 * out, 0.05, 0.45]]))


def laying(share: np.ndarray, sides=(1,)) -> np.ndarray:
    """Directions (frames, 9, 3) of standing that lay forearms before the belly by a share ``(frames,)``."""
    motion = np.tile(rest.REST.astype(float), (len(share), 1, 1))
    for side in sides:
        arm = list(skeleton.ARMS[side])
        motion[:, arm] = rest.slerp(motion[:, arm], laid(side), share[:, None])
    return motion.astype(np.float32)


def plateau(begin: float, end: float, seconds: float = 6.0, way: float = 0.5) -> np.ndarray:
    """From 0 to 1 before ``begin``, and back after ``end``, all seconds."""
    time = np.arange(round(seconds * FPS)) / FPS
    share = np.clip(np.minimum(time - begin + way, end + way - time) / way, 0, 1)
    return share * share * (3 - 2 * share)


def beyond(motion: np.ndarray, side: int) -> np.ndarray:
    """Metres of a palm beyond the body's middle."""
    points, lower = skeleton.to_positions(motion), skeleton.ARMS[side][1]
    palm = points[:, skeleton.EDGES[lower][1]] + 0.08 * motion[:, lower]
    return (palm - 0.5 * (points[:, 4] + points[:, 7]))[:, 0] * (-1 if side else 1)


@pytest.mark.parametrize("side", [0, 1])
def test_a_forearm_that_stays_across_the_belly_comes_back(side):
    drawn = laying(plateau(1.5, 4.5), (side,))
    made = apply(midline_dwell, drawn)
    before, after = beyond(drawn, side), beyond(made, side)
    assert before[30:60].min() > 0.05
    np.testing.assert_allclose(after[22:27], before[22:27], atol=0.002)  # it may come there
    assert after[45:65].max() < 0.015 and (after > 0.02).sum() / FPS < 1.2
    np.testing.assert_allclose(made[:16], drawn[:16], atol=1e-6)
    np.testing.assert_allclose(made[-8:], drawn[-8:], atol=1e-6)
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[side]]
    np.testing.assert_array_equal(made[:, others], drawn[:, others])
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    for order in (1, 2):
        before, after = (np.diff(skeleton.wrists(one)[:, side], order, axis=0) for one in (drawn, made))
        assert np.linalg.norm(after, axis=-1).max() <= np.linalg.norm(before, axis=-1).max() + 1e-6
    assert limits.penetration(made).max() <= limits.penetration(drawn).max()


def test_a_moment_across_stays_to_the_bit():
    drawn = laying(plateau(2.0, 2.2))
    assert beyond(drawn, 1).max() > 0.05
    np.testing.assert_array_equal(apply(midline_dwell, drawn), drawn)


def test_hands_on_their_own_side_and_hanging_ones_stay_to_the_bit():
    ahead = np.tile(skeleton.MEAN_UNIT, (90, 1, 1)).astype(np.float32)
    ahead[:, [5, 8]] = [0, 0, 1]
    low = np.tile(rest.REST, (90, 1, 1)).astype(np.float32)
    low[:, skeleton.ARMS[1]] = skeleton.normalize(np.array([[-0.3, 0.94, 0.15], [-0.4, 0.9, 0.1]]))
    assert beyond(low, 1).min() > 0
    for still in (ahead, low, np.tile(rest.REST, (90, 1, 1)).astype(np.float32)):
        np.testing.assert_array_equal(apply(midline_dwell, still), still)


def test_a_hug_opens_at_once():
    drawn = laying(plateau(2.0, 2.2), (0, 1))
    made = apply(midline_dwell, drawn)
    both = np.minimum(beyond(drawn, 0), beyond(drawn, 1))
    after = np.minimum(beyond(made, 0), beyond(made, 1))
    assert both.max() > 0.05 and after.max() < 0.02
    assert np.abs(np.diff(made, axis=0)).max() < 1.04 * np.abs(np.diff(drawn, axis=0)).max()


def test_given_frames_stay():
    drawn = laying(plateau(1.5, 4.5))
    given = np.arange(40, 50)
    made = apply(midline_dwell, drawn, given)
    np.testing.assert_array_equal(made[given], drawn[given])
    assert np.abs(np.diff(made, axis=0)).max() < 1.04 * np.abs(np.diff(drawn, axis=0)).max()
