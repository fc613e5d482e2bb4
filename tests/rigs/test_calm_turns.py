"""Turns about an arm's axis that change sides in a frame are spread over time; others stay to the bit."""

import numpy as np
from s2ag.core.motion import handshape
from s2ag.core.motion.hands import Hands
from s2ag.rigs import seat
from s2ag.rigs.proportions import FASTEST, calm


def test_a_turn_that_changes_sides_takes_time_and_a_quick_one_stays():
    time = np.arange(96) / 24
    quick = 0.9 * FASTEST / 9 * np.sin(9 * time)  # as fast as people shake a hand
    np.testing.assert_array_equal(calm(quick, 24), quick)
    flipped = calm(np.where(time < 2, -1.0, 1.2), 24)
    assert np.abs(np.diff(flipped)).max() * 24 < FASTEST
    np.testing.assert_array_equal(flipped[[0, 20, 75, 95]], [-1.0, -1.0, 1.2, 1.2])


def test_a_palm_that_faces_up_is_laid_down_at_an_even_pace():
    frames = 49
    ahead = np.broadcast_to([0.0, 0.0, 1.0], (frames, 2, 3))
    over = np.radians(np.linspace(170, 190, frames))[:, None]  # past the half turn while it is laid
    palms = np.stack([np.sin(over), np.cos(over), np.zeros_like(over)], -1)
    flat = np.broadcast_to(0.5 * handshape.RELAXED, (frames, 2, 12))
    lying = Hands.of(ahead, np.broadcast_to([0.0, 1.0, 0.0], ahead.shape), flat)
    shares = np.repeat(0.5 - 0.5 * np.cos(np.linspace(0, np.pi, frames))[:, None], 2, 1)
    led = seat._turned(Hands.of(ahead, np.broadcast_to(palms, ahead.shape), flat), lying, shares)
    steps = np.degrees(np.arccos(np.clip((led.palms[1:] * led.palms[:-1]).sum(-1), -1, 1)))
    assert steps.max() < (np.pi / 2 * 190 + 20) / (frames - 1)  # the steepest share of the whole turn, and its own change
    np.testing.assert_allclose(led.palms[-1], lying.palms[-1], atol=1e-6)
    np.testing.assert_allclose(led.palms[0], palms[0].repeat(2, 0), atol=1e-6)
