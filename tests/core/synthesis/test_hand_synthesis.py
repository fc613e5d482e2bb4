"""Hands for performances that have none."""

import numpy as np
import pytest
from bodies import degrees
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.synthesis import hand_synthesis

NAMES = ("calm lecturer", "warm host", "grand orator")


def gestures(frames=150, size=0.5):
    """Hanging arms whose right forearm rises and sinks each two seconds."""
    directions = np.repeat(skeleton.REST[None].astype(float), frames, 0)
    lift = size * (1 - np.cos(2 * np.pi * 0.5 * np.arange(frames) / 15))
    directions[:, 8] += lift[:, None] * [0.2, -0.7, 0.6]
    return skeleton.normalize(directions).astype(np.float32)


def test_hanging_hands_look_inwards_and_point_down():
    hands = hand_synthesis.synthesize_hands(np.repeat(skeleton.REST[None], 60, 0), NAMES[0])
    for side, inward in enumerate(([1, 0, 0], [-1, 0, 0])):
        assert degrees(hands.palms[:, side], np.array(inward)).max() < 60
        assert degrees(hands.knuckles[:, side], np.array([0, 1.0, 0.2])).max() < 35


def test_a_raised_forearm_turns_its_palm_from_the_thigh_and_the_other_stays():
    hands = hand_synthesis.synthesize_hands(gestures(), NAMES[0])
    moved = degrees(hands.palms[15], hands.palms[0])
    assert moved[1] > 15 and moved[0] < 5


def test_fingers_shape_with_strokes_and_rest_within_joints():
    busy, still = (
        hand_synthesis.synthesize_hands(one, NAMES[0]) for one in (gestures(), np.repeat(skeleton.REST[None], 150, 0))
    )
    for hands in (busy, still):
        assert (hands.shape >= handshape.LOW).all() and (hands.shape <= handshape.HIGH).all()
        assert handshape.column(hands.shape, "spread").max() < 15  # never splayed
    speed = [np.abs(np.diff(hands.shape[:, 1, :8], axis=0)).mean() * 15 for hands in (busy, still)]
    assert speed[0] > 1.5 * speed[1] and speed[1] > 0.5


def test_the_wrist_stays_behind_its_forearm():
    """A forearm passes the same places up and down; on its way up the hand hangs lower."""
    hands = hand_synthesis.synthesize_hands(gestures(), NAMES[0])
    up = np.arange(33, 43)
    apart = hands.knuckles[up, 1, 1] - hands.knuckles[90 - up, 1, 1]
    assert apart.mean() > 0.05
    assert np.abs(np.diff(hands.knuckles, n=2, axis=0)).max() < 0.2


def test_seeds_styles_and_nothing_else_make_the_difference():
    directions = gestures()
    first, again = (hand_synthesis.synthesize_hands(directions, NAMES[0], 3) for _ in range(2))
    np.testing.assert_array_equal(first.shape, again.shape)
    np.testing.assert_array_equal(first.palms, again.palms)
    assert np.abs(hand_synthesis.synthesize_hands(directions, NAMES[0], 4).shape - first.shape).max() > 5
    assert len({hand_synthesis.relaxed_handshape(name).round(2).tobytes() for name in NAMES}) == len(NAMES)


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_the_shortest_performances(frames):
    assert len(hand_synthesis.synthesize_hands(gestures(frames), NAMES[0])) == frames


def test_right_hands_are_what_left_ones_are_in_the_mirror():
    still = np.repeat(skeleton.REST[None], 40, 0)
    still = skeleton.normalize(still + skeleton.mirror(still))
    hands = hand_synthesis.synthesize_hands(still, NAMES[0])
    np.testing.assert_allclose(hands.mirrored().palms, hands.palms, atol=1e-5)
    assert isinstance(hands, Hands)
