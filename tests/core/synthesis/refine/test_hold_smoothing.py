"""Arms that wait are still, arms that gesture are as they were drawn."""

import numpy as np
from refining import apply
from s2ag.core.motion import rest, skeleton
from s2ag.core.synthesis.refine.hold_smoothing import hold_smoothing

ARMS = list(skeleton.ARM_EDGES)


def speeds(directions: np.ndarray) -> np.ndarray:
    """Degrees a second ``(frames - 1, 9)``."""
    cosine = (directions[1:].astype(float) * directions[:-1]).sum(-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1))) * skeleton.FPS


def trembling(frames: int = 300) -> np.ndarray:
    """A resting body whose arms tremble by half a degree."""
    noise = np.random.default_rng(1).normal(0, np.radians(0.5), (frames, 9, 3))
    return skeleton.normalize(rest.REST + noise).astype(np.float32)


def test_waiting_arms_hardly_move():
    drawn = trembling()
    settled = apply(hold_smoothing, drawn)
    assert np.median(speeds(drawn)[:, ARMS]) > 8
    assert np.median(speeds(settled)[:, ARMS]) < 0.25 * np.median(speeds(drawn)[:, ARMS])
    np.testing.assert_allclose(np.linalg.norm(settled, axis=-1), 1, atol=1e-5)


def test_head_and_trunk_stay_as_they_were_drawn():
    drawn = trembling()
    others = [edge for edge in range(9) if edge not in ARMS]
    np.testing.assert_array_equal(apply(hold_smoothing, drawn)[:, others], drawn[:, others])


def test_a_stroke_keeps_its_size_and_its_time():
    time = np.arange(300) / skeleton.FPS
    stroke = np.exp(-0.5 * ((time - 10) / 0.25) ** 2)
    drawn = trembling()
    away = skeleton.normalize(rest.REST[8] + np.array([0.0, -0.5, 1.0]))
    drawn[:, 8] = rest.slerp(drawn[:, 8].astype(float), away, stroke)
    settled = apply(hold_smoothing, drawn)
    before, after = (speeds(motion)[:, 8] for motion in (drawn, settled))
    assert after.max() > 0.9 * before.max()
    farthest = [int((motion[:, 8] @ away).argmax()) for motion in (drawn, settled)]
    assert abs(farthest[1] - farthest[0]) <= 1
    # the other arm waits meanwhile
    assert np.median(speeds(settled)[:, 5]) < 0.25 * np.median(speeds(drawn)[:, 5])


def test_short_motions_are_taken():
    assert apply(hold_smoothing, trembling(2)).shape == (2, 9, 3)
    one = trembling(1)
    np.testing.assert_allclose(apply(hold_smoothing, one), one, atol=1e-6)


def drifting(frames: int = 300) -> np.ndarray:
    """A body whose right forearm swings by 20 degrees, three times in two seconds."""
    time = np.arange(frames) / skeleton.FPS
    drawn = np.tile(rest.REST, (frames, 1, 1))
    away = skeleton.normalize(rest.REST[8] + np.array([0.0, 0.0, 1.0]))
    drawn[:, 8] = rest.slerp(drawn[:, 8].astype(float), away, 0.25 * np.sin(2 * np.pi * 1.5 * time))
    return drawn.astype(np.float32)


def test_where_a_take_answers_nothing_arms_wait_more_readily_and_elsewhere_as_ever():
    drawn, idle = drifting(), np.zeros(300)
    idle[150:] = 1
    settled = apply(hold_smoothing, drawn, idle=idle)
    often, rarely = speeds(apply(hold_smoothing, drawn))[:, 8], speeds(settled)[:, 8]
    np.testing.assert_allclose(rarely[:140], often[:140], atol=1e-6)
    assert rarely[160:290].mean() < 0.7 * often[160:290].mean()
