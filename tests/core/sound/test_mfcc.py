import numpy as np
import pytest
from s2ag.core.model.table_features import published_features
from s2ag.core.sound import audio, mfcc


def noise(samples, seed=0):
    return np.random.default_rng(seed).normal(0, 0.1, samples).astype(np.float32)


SIGNALS = {
    "a minute of noise": noise(960_000),
    "not a multiple of the hop": noise(36_267),
    "one window": noise(2048),
    "shorter than a window": noise(700),
    "one sample": noise(1),
    "silence": np.zeros(20_000, np.float32),
    "noise amid silence": np.concatenate([np.zeros(30_000, np.float32), noise(50_001), np.zeros(9_000, np.float32)]),
    "loud start": np.concatenate([noise(4000), noise(40_000) * np.float32(1e-5)]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.filterwarnings("ignore:n_fft=2048 is too large")
def test_equals_librosa(name):
    librosa = pytest.importorskip("librosa", reason="the reference implementation is not installed")
    signal = SIGNALS[name]
    expected = librosa.feature.mfcc(y=signal, sr=16000, n_mfcc=14).T
    assert np.abs(mfcc.mfcc(signal) - expected).max() <= 1e-4


@pytest.mark.slow
def test_speech_equals_librosa(examples):
    librosa = pytest.importorskip("librosa", reason="the reference implementation is not installed")
    sound = audio.load(examples / "hello.flac")
    assert np.abs(mfcc.mfcc(sound, 20) - librosa.feature.mfcc(y=sound, sr=16000).T).max() <= 1.3e-4  # two float32 steps at 600


def test_blocks_leave_no_seam(monkeypatch):
    signal = SIGNALS["loud start"]
    whole = mfcc.mfcc(signal)
    monkeypatch.setattr(mfcc, "_BLOCK", 7)
    np.testing.assert_allclose(mfcc.mfcc(signal), whole, atol=1e-4)


def test_only_mono(examples):
    with pytest.raises(ValueError, match="mono"):
        mfcc.mfcc(np.zeros((2, 16000), np.float32))


def test_published_features_of_a_window():
    """Reference section A.2: 36,267 samples are 71 frames, rows 14 + 12 + 11, differences along the coefficients."""
    signal = noise(36_267)
    features = published_features(signal)
    assert features.shape == (37, 71)
    coefficients = mfcc.mfcc(signal).T / 1000
    np.testing.assert_allclose(features[:14], coefficients, atol=1e-7)
    np.testing.assert_allclose(features[14 + 3], coefficients[5] - coefficients[4], atol=1e-6)
    np.testing.assert_allclose(features[26 + 2], coefficients[5] - 2 * coefficients[4] + coefficients[3], atol=1e-6)


def test_temporal_features_are_of_order_one_for_speech(examples):
    features = mfcc.temporal_features(audio.load(examples / "hello.flac"))
    assert features.shape[1] == mfcc.FEATURES and features.dtype == np.float32
    assert np.abs(features.mean(0)).max() < 1.5
    spread = features.std(0)
    assert spread.min() > 0.3 and spread.max() < 2


def test_temporal_features_ignore_microphone_gain(examples):
    sound = audio.load(examples / "hello.flac")
    np.testing.assert_allclose(mfcc.temporal_features(sound * np.float32(0.02)), mfcc.temporal_features(sound), atol=1e-3)


def test_temporal_slopes_run_along_time(examples):
    features = mfcc.temporal_features(audio.load(examples / "hello.flac"))
    steps = np.arange(-2, 3)
    for frame in (10, 100, 300):
        slope = np.polyfit(steps, features[frame - 2 : frame + 3, :13], 1)[0]
        np.testing.assert_allclose(features[frame, 14:27], 3 * slope, atol=1e-4)


def test_temporal_features_of_silence_are_finite_and_still():
    features = mfcc.temporal_features(np.zeros(16000, np.float32))
    assert np.isfinite(features).all() and np.abs(features).max() < 4
    assert np.abs(features[:, 14:]).max() == 0
