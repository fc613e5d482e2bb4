"""Hands of directed performances."""

from dataclasses import replace

import captured
import numpy as np
import pytest
from bodies import degrees
from s2ag.core.learning.corpus import authored, hand_blending, library, planning, rendering, speakers, variation
from s2ag.core.learning.evaluate import hand_speeds as evaluated
from s2ag.core.motion import handshape, rest, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.synthesis import hand_synthesis

PERFORMER = speakers.PERFORMERS[0]
FLAT = np.array([2.0, 3, 2, 3, 2, 3, 2, 3, 40, 5, 6, 20])


def stroke_of(clip, at=2.0):
    gesture = library.Gesture(clip, "Set", "BeatMid", "beat", False, 0.0, 0.4)
    part = variation.ArmPart(gesture, 0.0, np.zeros(3), (1.0, 1.0))
    return planning.Stroke(
        gesture, at - 0.7, at - 0.3, at, at + 0.2, (at + 0.6,) * 2, (at + 1.2,) * 2, 1.0, parts=(None, part)
    )


@pytest.fixture
def clip():
    """A raised right forearm whose palm looks up and whose fingers are flat."""
    plain = captured.wave_clip()
    frames = len(plain.directions)
    palms = np.tile([0.0, -1.0, 0.0], (frames, 2, 1))
    return replace(plain, fingers=Hands.of(plain.directions[:, [5, 8]], palms, np.tile(FLAT, (frames, 2, 1))))


def directed(clip):
    stroke = stroke_of(clip)
    still = np.repeat(rest.REST[None].astype(float), 75, 0)
    body = rendering.blend_gestures(still, [stroke], np.arange(75) / skeleton.FPS).astype(np.float32)
    alone = hand_synthesis.synthesize_hands(body, PERFORMER.name, 3)
    return body, hand_blending.blend_captured(alone, [stroke], body), alone


def test_a_captured_hand_is_played_with_its_arm_and_only_then(clip):
    _, hands, alone = directed(clip)
    at = round(2.0 * skeleton.FPS)
    assert degrees(hands.palms[at, 1], np.array([0, -1.0, 0])) < 35
    np.testing.assert_allclose(hands.shape[at, 1], FLAT, atol=4)
    for part in ("palms", "knuckles", "shape"):
        mine, theirs = getattr(hands, part), getattr(alone, part)
        np.testing.assert_allclose(mine[:, 0], theirs[:, 0], atol=1e-3)  # the left hand has no part
        np.testing.assert_allclose(mine[:10, 1], theirs[:10, 1], atol=1e-3)


def test_thumbs_of_skeletons_that_have_them_wrong_are_not_shown(clip):
    odd = replace(clip, fingers=replace(clip.fingers, shape=clip.fingers.shape + np.float32(30)), thumbs=False)
    _, hands, alone = directed(odd)
    at = round(2.0 * skeleton.FPS)
    for name in ("thumb_out", "thumb_bend"):
        np.testing.assert_allclose(
            handshape.column(hands.shape[at, 1], name), handshape.column(alone.shape[at, 1], name), atol=1e-3
        )
    assert hands.shape[at, 1, 0] > alone.shape[at, 1, 0] + 5


def test_authored_gestures_show_their_palms():
    for meaning, label, clip in authored.clips():
        at = round(clip.emphasis * clip.fps)
        up = -clip.fingers.palms[at, :, 1]
        inward = clip.fingers.palms[at, :, 0] * [1, -1]
        assert (up > 0.6).all() if meaning in ("unknown", "however") else (inward > 0.5).all(), label
        np.testing.assert_allclose(clip.fingers.shape[0], hand_synthesis.hanging_hands(rest.REST[None]).shape[0], atol=0.5)


def test_speeds_are_those_of_hands_that_turn_on_their_forearms():
    """A hand that turns at 30 degrees a second about its forearm, which moves, and fingers that bend at 24."""
    frames = 60
    body = np.repeat(rest.REST[None], frames, 0).astype(float)
    body[:, 8] = skeleton.normalize(np.stack([np.zeros(frames), np.linspace(0.4, -0.4, frames), np.ones(frames)], -1))
    along = body[:, [5, 8]]
    side = np.broadcast_to([1.0, 0, 0], along.shape)
    angle = np.radians(2.0 * np.arange(frames))[:, None, None]
    palms = np.cos(angle) * side + np.sin(angle) * np.cross(along, side)
    shape = np.tile(handshape.RELAXED, (frames, 2, 1)) + (1.6 * (np.arange(frames) % 2))[:, None, None]
    found = evaluated.speeds(body, Hands.of(along, palms, shape), rest.REST)
    assert found["wrist_speed"] == pytest.approx(30, abs=1) and found["finger_speed"] == pytest.approx(24, abs=0.1)
    nobody = evaluated.speeds(np.repeat(rest.REST[None], frames, 0), Hands.of(along, palms, shape), rest.REST)
    assert np.isnan(nobody["wrist_speed"])
