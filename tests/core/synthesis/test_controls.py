"""Controls steer a style along the directions that the network has learned, and nothing else."""

import numpy as np
import pytest
from s2ag.core import styles
from s2ag.core.errors import UsageError
from s2ag.core.motion import limits, skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis import style_sequence
from s2ag.core.synthesis.session import Request, Session
from sounds import write_wav

pytest.importorskip("torch", reason="the engine is not installed")


@pytest.fixture(scope="module")
def voice(tmp_path_factory):
    """Four seconds of noise in bursts."""
    samples = np.random.default_rng(0).normal(0, 0.1, 64000) * (np.sin(np.arange(64000) / 2500) > -0.3)
    path = tmp_path_factory.mktemp("audio") / "bursts.wav"
    write_wav(path, samples)
    return path


@pytest.fixture(scope="module")
def session(random_checkpoint):
    return Session(random_checkpoint)


def perform(session, voice, **options):
    return session.synthesize(Request(voice, style="calm one", **options)).motions


def latents(session, voice, **options):
    """The styles that a request ends up with, ``(takes, size)``."""
    weights = styles.parse("calm one", ["calm one", "lively one"])
    return style_sequence.draw_latents(session.checkpoint, Request(voice, **options), weights)


@pytest.mark.parametrize("control", [{"affect": {name: 1.0}} for name in styles.AFFECTS] + [{"rate": 1.0}, {"hand": 1.0}])
def test_a_control_changes_the_motion_and_its_sign_turns_the_change_round(session, voice, control):
    opposite = {name: {key: -1.0 for key in value} if name == "affect" else -1.0 for name, value in control.items()}
    plain, there, back = (latents(session, voice, **options) for options in ({}, control, opposite))
    assert np.abs(there - plain).max() > 0.05
    np.testing.assert_allclose(there - plain, plain - back, atol=1e-6)
    moved = perform(session, voice, **control)[0].directions - perform(session, voice)[0].directions
    assert np.abs(moved).max() > 1e-3


def test_takes_after_the_first_vary_what_is_asked_but_never_the_hand():
    asked = np.array([0.5, 0, 0, 0.9, -1], np.float32)
    wishes = styles.vary_controls(asked, seed=3, takes=6)
    np.testing.assert_array_equal(wishes[0], asked)
    np.testing.assert_array_equal(wishes[:, 4], -1)
    assert np.abs(wishes[1:, :4] - asked[:4]).max(1).min() > 0.02 and np.abs(wishes).max() <= 1
    np.testing.assert_array_equal(wishes[:3], styles.vary_controls(asked, seed=3, takes=3))


def test_each_control_has_a_direction_of_its_own(session, voice):
    plain = latents(session, voice)
    moves = np.concatenate(
        [latents(session, voice, affect={name: 1.0}) - plain for name in styles.AFFECTS]
        + [latents(session, voice, **{name: 1.0}) - plain for name in ("rate", "hand")]
    )
    expected = session.checkpoint.network.ways
    np.testing.assert_allclose(moves, expected, atol=1e-6)


def test_zeros_change_nothing_and_the_same_wishes_give_the_same_motion(session, voice):
    plain = perform(session, voice)[0]
    zeros = perform(session, voice, affect={"arousal": 0.0, "valence": 0}, rate=0, hand=0)[0]
    assert plain.directions.tobytes() == zeros.directions.tobytes()
    wishes = {"affect": {"arousal": 0.7}, "hand": -0.5, "takes": 2, "seed": 4}
    for first, again in zip(perform(session, voice, **wishes), perform(session, voice, **wishes), strict=True):
        assert first.directions.tobytes() == again.directions.tobytes() and first.meta == again.meta


def test_a_random_style_is_steered_too(session, voice):
    plain, steered = (
        session.synthesize(Request(voice, style="random", seed=2, rate=rate)).motions[0].directions for rate in (0, 1)
    )
    assert np.abs(plain - steered).max() > 1e-3


def test_controls_are_kept_with_the_motion(session, voice, tmp_path):
    motion = perform(session, voice, affect={"valence": np.float32(0.5)}, rate=1, hand=-0.25)[0]
    motion.save(tmp_path / "a.npz")
    meta = Motion.load(tmp_path / "a.npz").meta
    assert (meta["affect"], meta["rate"], meta["hand"]) == ({"valence": 0.5}, 1.0, -0.25)


def test_a_checkpoint_without_controls_refuses_them_and_works_without(plain_checkpoint, voice):
    session = Session(plain_checkpoint)
    for wish in ({"affect": {"arousal": 0.1}}, {"rate": 1}, {"hand": -1}):
        with pytest.raises(UsageError, match="no control") as error:
            perform(session, voice, **wish)
        assert error.value.remedy
    assert len(perform(session, voice, affect={"arousal": 0.0})) == 1


def test_mirroring_exchanges_a_steered_performance(session, voice):
    plain, mirrored = (perform(session, voice, hand=1.0, mirror=mirror)[0].directions for mirror in (False, True))
    np.testing.assert_array_equal(mirrored, skeleton.mirror(plain))


@pytest.mark.parametrize("intensity", [1.0, 3.0])
def test_whatever_the_network_makes_is_human(session, voice, intensity):
    """The network is random and exaggerated, and the limits come last."""
    for motion in perform(session, voice, takes=4, intensity=intensity, affect={"arousal": 1.0}):
        assert not limits.backward_elbows(motion.directions).any()
        assert limits.penetration(motion.directions).max() < limits.MAX_PENETRATION
        assert limits.wrist_distance(motion.directions).min() >= limits.MIN_WRIST_DISTANCE
