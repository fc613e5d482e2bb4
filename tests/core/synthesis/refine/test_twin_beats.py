import numpy as np
import pytest
from refining import apply
from s2ag.core.motion import rest, skeleton
from s2ag.core.synthesis import constraints
from s2ag.core.synthesis.refine.twin_beats import twin_beats

FPS = skeleton.FPS
FRAMES, AT = 90, 45


def raising(*shares: np.ndarray) -> np.ndarray:
    """Directions (frames, 9, 3) of standing whose left and right forearm are raised by shares ``(frames,)`` of 90 degrees."""
    motion = np.tile(rest.REST.astype(float), (len(shares[0]), 1, 1))
    for (_, lower), share in zip(skeleton.ARMS, shares, strict=True):
        up = np.broadcast_to(skeleton.normalize(np.array([0.0, -0.3, 0.95])), (len(share), 3))
        motion[:, lower] = rest.slerp(motion[:, lower], up, share)
    return motion.astype(np.float32)


def bump(seconds: float, at: int = AT) -> np.ndarray:
    """Up and down again ``(frames,)``, so many seconds from half-way up to half-way down."""
    time = (np.arange(FRAMES) - at) / FPS
    return np.where(np.abs(time) < seconds, 0.5 + 0.5 * np.cos(np.pi * time / seconds), 0)


def heights(motion: np.ndarray, side: int) -> np.ndarray:
    """Metres of a wrist above where it begins."""
    found = -skeleton.wrists(motion)[:, side, 1]
    return found - found[0]


@pytest.mark.parametrize("side", [0, 1])
def test_the_slower_of_two_arms_that_are_thrown_up_goes_not_so_far(side):
    shares = [0.7 * bump(0.3), bump(0.3, AT + 1)]
    drawn = raising(*shares[:: -1 if side else 1])
    made = apply(twin_beats, drawn)
    before, after = heights(drawn, side), heights(made, side)
    assert before.max() > 0.2 and 0.2 * before.max() < after.max() < 0.75 * before.max()
    for order in (1, 2):
        assert np.abs(np.diff(after, order)).max() < 0.7 * np.abs(np.diff(before, order)).max()
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[side]]
    np.testing.assert_array_equal(made[:, others], drawn[:, others])
    np.testing.assert_array_equal(made[[0, 20, 70, -1]], drawn[[0, 20, 70, -1]])
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(skeleton.mirror(apply(twin_beats, skeleton.mirror(drawn))), made, atol=1e-6)


def test_arms_that_beat_one_after_the_other_or_alone_stay_to_the_bit():
    for shares in ((bump(0.3), np.zeros(FRAMES)), (bump(0.3), bump(0.3, AT + 8)), (np.zeros(FRAMES), np.zeros(FRAMES))):
        drawn = raising(*shares)
        np.testing.assert_array_equal(apply(twin_beats, drawn), drawn)


def test_what_takes_its_time_stays_up_or_is_small_stays_to_the_bit():
    held = np.clip(np.minimum(np.arange(FRAMES) - 20, 70 - np.arange(FRAMES)) / 4, 0, 1)
    for share in (bump(1.4), 0.12 * bump(0.3), held, np.linspace(0, 1, FRAMES)):
        drawn = raising(0.9 * share, share)
        np.testing.assert_array_equal(apply(twin_beats, drawn), drawn)


def test_it_sets_in_with_speed_size_and_how_much_together_arms_are():
    for drawn in (
        [raising(0.9 * bump(seconds), bump(seconds)) for seconds in np.linspace(0.3, 1.0, 71)],
        [raising(0.9 * size * bump(0.3), size * bump(0.3)) for size in np.linspace(0, 1, 101)],
    ):
        changed = [np.abs(apply(twin_beats, one) - one).mean() for one in drawn]
        assert max(changed) > 0.0025 and np.abs(np.diff(changed)).max() < 0.0006


def test_given_frames_stay():
    drawn = raising(0.7 * bump(0.3), bump(0.3))
    given = np.arange(AT, FRAMES)
    made = apply(twin_beats, drawn, given)
    np.testing.assert_array_equal(made[given], drawn[given])
    assert np.abs(np.diff(made, axis=0)).max() <= np.abs(np.diff(drawn, axis=0)).max() + 0.01


def test_short_motions_stay():
    for frames in (1, 2, 3):
        drawn = raising(*2 * [np.linspace(0, 1, frames)])
        np.testing.assert_array_equal(apply(twin_beats, drawn), drawn)


def test_frames_may_be_mended_away_from_given_ones():
    assert (constraints.freedom(5) == 1).all()
    free = constraints.freedom(60, np.array([31, 30]))
    assert (free[30:32] == 0).all() and free[0] == free[59] == 1
    assert (np.diff(free[:31]) <= 0).all() and (np.diff(free[31:]) >= 0).all() and np.abs(np.diff(free)).max() < 0.15
