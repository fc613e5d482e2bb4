"""Metrics: identities, hand-computed values, known orderings, and an extractor that is refused when it has collapsed."""

import numpy as np
import pytest
from s2ag.core.errors import UsageError
from s2ag.core.learning.metrics import dynamics, frechet, joint_errors, rhythm, variety
from s2ag.core.motion import skeleton

RNG = np.random.default_rng(0)


def gestures(count=64, frames=34, size=0.5, seed=0):
    """Arms that swing at random places, speeds and sizes."""
    rng = np.random.default_rng(seed)
    time = np.arange(frames) / 15
    phase, pace = rng.uniform(0, 6, (count, 1)), rng.uniform(1, 3, (count, 1))
    directions = np.broadcast_to(skeleton.MEAN_UNIT, (count, frames, 9, 3)).copy()
    directions[:, :, [4, 5, 7, 8], 1] -= (rng.uniform(0, size, (count, 1)) * np.sin(pace * time + phase))[..., None]
    directions[:, :, [5, 8], 0] += rng.normal(0, size, (count, 1, 2))
    return skeleton.normalize(directions)


def test_nothing_differs_from_itself():
    real = gestures()
    for figure in (joint_errors.maje_code, joint_errors.mpjpe, joint_errors.mad_code, joint_errors.mad_norm):
        assert figure(real, real) == 0
    features = RNG.normal(size=(200, 8))
    assert frechet.frechet_distance(features, features) == pytest.approx(0, abs=1e-9)
    assert dynamics.hellinger([1, 2, 3], [2, 4, 6]) == pytest.approx(0, abs=1e-7)
    assert dynamics.canonical_correlation(features, features @ RNG.normal(size=(8, 8))) == pytest.approx(1)


def test_errors_by_hand():
    """A torso turned by a right angle moves the neck and everything above it by 0.26 along x and 0.26 along y."""
    real = np.broadcast_to(np.array([0.0, -1.0, 0.0]), (2, 34, 9, 3)).copy()
    made = real.copy()
    made[:, :, 0] = [1.0, 0.0, 0.0]
    assert joint_errors.maje_code(made, real) == pytest.approx(1000 * 9 * 2 * 0.26 / 30)
    assert joint_errors.mpjpe(made, real) == pytest.approx(1000 * 0.26 * 2**0.5)
    assert joint_errors.mad_code(made, real) == 0
    made = real.copy()
    made[:, 10, 0] *= 1.5  # the neck jumps up by 0.13 for one frame: second differences 1, -2, 1
    assert joint_errors.mad_code(made, real) == pytest.approx(1000 * 4 * 0.13 * 9 / 30 / 32)
    assert joint_errors.mad_seconds(made, real) == pytest.approx(225 * joint_errors.mad_code(made, real))
    assert joint_errors.mpjpe(made, real) == 0 and joint_errors.mad_norm(made, real) == 0  # bones keep their length there


def test_seeds_count_in_accelerations_only():
    real = gestures(4)
    made = real.copy()
    made[:, :2] = skeleton.mirror(made[:, :2])
    assert joint_errors.maje_code(made, real) == joint_errors.mpjpe(made, real) == 0
    assert joint_errors.mad_code(made, real) > 0


def test_frechet_distance_of_known_normals():
    a = RNG.normal(size=(200_000, 2))
    b = RNG.normal(size=(200_000, 2)) * [2, 1] + [3, 0]
    assert frechet.frechet_distance(a, b) == pytest.approx(9 + 1, rel=0.02)
    assert frechet.frechet_distance(a, b) == pytest.approx(frechet.frechet_distance(b, a), rel=1e-6)
    with pytest.raises(UsageError, match="two samples"):
        frechet.frechet_distance(a[:1], b)
    with pytest.raises(UsageError, match="not finite"):
        frechet.frechet_distance(a, np.full((3, 2), np.nan))


def test_frechet_distance_equals_the_textbook_root():
    from scipy.linalg import sqrtm

    a, b = RNG.normal(size=(500, 6)), RNG.normal(size=(400, 6)) @ RNG.normal(size=(6, 6))
    means, covs = [part.mean(0) for part in (a, b)], [np.cov(part, rowvar=False) for part in (a, b)]
    expected = ((means[0] - means[1]) ** 2).sum() + np.trace(covs[0] + covs[1] - 2 * sqrtm(covs[0] @ covs[1]).real)
    assert frechet.frechet_distance(a, b) == pytest.approx(expected, rel=1e-8)


def test_more_noise_is_farther_by_every_measure():
    real = gestures(200)
    near, far = (real + RNG.normal(0, size, real.shape) for size in (0.02, 0.2))
    for figure in (joint_errors.maje_code, joint_errors.mpjpe, joint_errors.mad_code, joint_errors.mad_norm):
        assert 0 < figure(near, real) < figure(far, real)
    bins = [dynamics.wrist_speed_histogram(motion) for motion in (real, near, far)]
    assert 0 < dynamics.hellinger(bins[0], bins[1]) < dynamics.hellinger(bins[0], bins[2]) <= 1
    assert dynamics.mean_derivative(real, 3) < dynamics.mean_derivative(near, 3) < dynamics.mean_derivative(far, 3)


def test_a_frozen_figure_has_no_motion():
    still = np.broadcast_to(skeleton.MEAN_UNIT, (5, 34, 9, 3))
    assert dynamics.mean_derivative(still, 2) == pytest.approx(0, abs=1e-6) and variety.l1_diversity(still) < 1e-6
    assert dynamics.wrist_speed_histogram(still)[0] == 1
    marks = [np.array([1.0])] * 5
    assert rhythm.beat_alignment(still, marks) == 0
    assert np.isnan(rhythm.beat_consistency(still, marks))


def test_derivatives_in_true_units():
    """A neck on a circle of 0.26 m at w rad/s: acceleration 0.26 w^2, and everything above is carried along."""
    pace, fps = 1.0, 240.0
    angle = pace * np.arange(500) / fps
    directions = np.broadcast_to(np.array([0.0, -1.0, 0.0]), (1, 500, 9, 3)).copy()
    directions[0, :, 0] = np.stack([np.sin(angle), -np.cos(angle), 0 * angle], -1)
    assert dynamics.mean_derivative(directions, 2, fps) == pytest.approx(260, rel=1e-3)


def test_beats_on_the_onsets_score_higher():
    frames = 60
    time = np.arange(frames) / 15
    motions = np.broadcast_to(skeleton.MEAN_UNIT, (1, frames, 9, 3)).copy()
    angle = np.sin(2 * np.pi * 0.5 * time) * 0.8  # turns, and so is slowest, at 0.5 s, 1.5 s, 2.5 s
    motions[0, :, 5] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], -1)
    turns = np.array([0.5, 1.5, 2.5, 3.5])
    assert rhythm.motion_beats(motions[0]) == pytest.approx(turns, abs=0.07)
    assert rhythm.beat_alignment(motions, [turns]) > 0.6 > 0.1 > rhythm.beat_alignment(motions, [turns + 0.5])
    assert rhythm.beat_consistency(motions, [turns]) > rhythm.beat_consistency(motions, [turns + 0.5])
    assert np.isnan(rhythm.beat_alignment(motions, [np.zeros(0)]))


def test_onsets_are_heard():
    pytest.importorskip("librosa")
    wave = np.zeros(32000, np.float32)
    for start in (8000, 20000):
        wave[start : start + 2000] = np.sin(np.arange(2000) * 0.3) * np.exp(-np.arange(2000) / 500)
    found = rhythm.onsets(wave)
    assert all(np.abs(found - start).min() < 0.06 for start in (0.5, 1.25))


def test_variety():
    features = RNG.normal(size=(300, 4))
    assert variety.diversity(features) > variety.diversity(features / 2) > variety.diversity(0 * features) == 0
    assert variety.multimodality(features[None]) == 0
    assert variety.multimodality(np.stack([features, features + [3, 4, 0, 0]])) == pytest.approx(5)
    assert variety.l1_diversity(gestures(size=0.6)) > variety.l1_diversity(gestures(size=0.1))


def test_canonical_correlation_of_strangers_is_low():
    a, b = RNG.normal(size=(5000, 5)), RNG.normal(size=(5000, 5))
    assert dynamics.canonical_correlation(a, b) < 0.1
    b[:, 2] = 3 * a[:, 1] - 7
    assert dynamics.canonical_correlation(a, b) == pytest.approx(1)
    assert dynamics.canonical_correlation(a, np.ones((5000, 2))) == 0


@pytest.mark.slow
def test_extractor_is_the_published_one_and_learns():
    torch = pytest.importorskip("torch")
    from s2ag.core.learning.metrics import extractor

    torch.set_num_threads(1)
    real = gestures(4000).astype(np.float32)
    fresh = extractor.Extractor()
    count = sum(p.numel() for p in fresh.parameters())
    assert count == 170_240 - 33 * 32 + 20_451  # less the unused head of log-variances
    untrained = extractor.check_extractor(fresh.eval(), real[3000:])
    with pytest.raises(UsageError, match="collapsed"):
        extractor.require_valid(untrained)
    trained = extractor.train_extractor(lambda rng, count: real[rng.integers(3000, size=count)], steps=400, seed=1)
    found = extractor.check_extractor(trained, real[3000:])
    extractor.require_valid(found)
    features = trained.features(real)
    worse = [trained.features(real + s * RNG.normal(size=real.shape)) for s in (0.05, 0.3)]
    near, far = (frechet.frechet_distance(features, part) for part in worse)
    assert 0 < near < far
    assert frechet.feature_distance(features, features) == 0


def test_extractor_is_the_same_for_the_same_seed_and_survives_its_file(tmp_path):
    pytest.importorskip("torch")
    from s2ag.core.errors import CheckpointUnreadable
    from s2ag.core.learning.metrics import extractor

    real = gestures(300).astype(np.float32)
    one, two = (extractor.train_extractor(lambda rng, n: real[rng.integers(300, size=n)], 3, seed=4) for _ in range(2))
    np.testing.assert_array_equal(one.features(real), two.features(real))
    one.save(tmp_path / "e.safetensors")
    np.testing.assert_array_equal(extractor.Extractor.load(tmp_path / "e.safetensors").features(real), one.features(real))
    (tmp_path / "e.safetensors").write_bytes(b"x")
    with pytest.raises(CheckpointUnreadable, match="holds no extractor"):
        extractor.Extractor.load(tmp_path / "e.safetensors")


def test_a_frozen_extractor_is_refused():
    pytest.importorskip("torch")
    from s2ag.core.learning.metrics import extractor

    with pytest.raises(UsageError, match="held mean pose"):
        extractor.require_valid({"missed": 0.1, "halves": 1.0, "still": 2.0, "ratio": 2.0})
