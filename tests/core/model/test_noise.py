"""Chance in bands: any part is that of the whole, lines begin far from one another, and mood, not chance, opens arms."""

import numpy as np
from s2ag.core.model.noise import BEYOND, beginning, in_bands, noise
from s2ag.core.motion import skeleton

PLACES = np.zeros((1, 27, 2)) + [1.0, 0.0]  # where hands live, without beats


def arms(seed: int, frames: int = 60) -> np.ndarray:
    """Slow numbers of both arms of one take ``(frames, 2, 2, 3)``."""
    numbers = in_bands(noise(seed, (0, ()), 0, frames + BEYOND, 27), PLACES)[:frames].reshape(frames, 9, 3)
    return numbers[:, [list(arm) for arm in skeleton.ARMS]]


def test_any_part_in_bands_is_that_of_the_whole():
    scale = np.broadcast_to([1.4, 2.0], (1, 27, 2))
    whole = in_bands(noise(3, (0, ()), 0, 900, 27), scale)
    part = in_bands(noise(3, (0, ()), 100, 900, 27), scale, 100)
    np.testing.assert_allclose(part[BEYOND : 800 - BEYOND], whole[100 + BEYOND : 900 - BEYOND], atol=1e-5)


def test_takes_begin_equally_far_from_the_usual_and_get_nearer_to_it():
    starts = np.stack([np.linalg.norm(arms(seed)[0], axis=(1, 2)) for seed in range(40)])
    np.testing.assert_allclose(starts, starts[0, 0], rtol=1e-4)
    later = np.stack([np.linalg.norm(arms(seed, 300)[-60:], axis=(2, 3)) for seed in range(40)])
    assert 2 < starts[0, 0] / later.mean() < 3.5 and np.ptp(later.mean(axis=(1, 2))) > 0.05


def test_a_take_begins_gradually_less():
    begins = beginning(0, 200)
    assert begins[0] == 1 and (np.diff(begins) < 0).all() and begins[-1] < 1e-6
    np.testing.assert_array_equal(beginning(50, 200), begins[50:])


def test_chance_moves_both_arms_aside_more_than_apart():
    left, right = np.moveaxis(np.concatenate([arms(seed, 300)[200:, ..., 0] for seed in range(60)]), 1, 0)
    apart, together = (np.std(right - left), np.std(right + left))
    assert 0.2 < apart / together < 0.4
