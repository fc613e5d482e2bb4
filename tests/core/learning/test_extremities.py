"""Hands of captured clips."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import captured_hands, clips, hand_model, rotation, smartbody
from s2ag.core.motion import handshape, skeleton
from s2ag.core.synthesis import hand_synthesis


def test_a_skeleton_that_stretches_its_arms_has_flat_hands_that_look_down(shared):
    path = shared / "smartbody" / "MaleGestures" / "skeletons" / "ChrGarza.sk"
    if not path.is_file():
        pytest.skip("the clips are absent")
    hands = captured_hands.read_hands(smartbody.load_skeleton(path), None, captured_hands.SMARTBODY, rotation.IDENTITY[None])
    np.testing.assert_allclose(hands.knuckles[0], [[-1, 0, 0], [1, 0, 0]], atol=0.05)
    np.testing.assert_allclose(hands.palms[0], [[0, 1, 0], [0, 1, 0]], atol=0.05)  # y is down
    for part in ("base", "rest"):
        assert np.abs(handshape.columns(hands.shape, part)).max() < 2


def test_what_is_learnt_gives_hands_back_that_follow_from_their_arms():
    """Clips whose palms and knuckles are made of known numbers: the numbers are found again."""
    learnt = {name: np.array(values) for name, values in hand_synthesis._learnt().items()}
    rng = np.random.default_rng(1)
    found = []
    for _ in range(4):
        directions = hand_model.Hands.of(*rng.normal(size=(2, 400, 9, 3)), np.zeros(12)).knuckles
        seen = [hand_synthesis.arm_features(directions[:, up], directions[:, fore]) for up, fore in skeleton.ARMS[:1] * 2]
        palms = np.stack([one @ learnt["palms"] for one in seen], 1) * [[1, 1, 1], [-1, 1, 1]]
        bends = np.stack([one @ learnt["knuckles"] for one in seen], 1) * [[1, 1, 1], [-1, 1, 1]]
        directions[:, 7:9] = directions[:, 4:6] * [-1, 1, 1]
        hands = hand_model.Hands(directions[:, [5, 8]] + bends, palms, np.tile(handshape.RELAXED, (400, 2, 1)))
        found.append(clips.Clip("a", 10.0, directions, 0, 0, 1.0, 0, 0, 0, (1.0, 1.0), hands))
    again = hand_model.fit(found)
    np.testing.assert_allclose(again["palms"], learnt["palms"], atol=0.05)
    np.testing.assert_allclose(again["knuckles"], learnt["knuckles"], atol=0.05)
    np.testing.assert_allclose(again["shapes"], np.tile(handshape.RELAXED, (len(again["shapes"]), 1)), atol=1e-3)
