"""Recorded sound: in its place to the sample, without what its band leaves out, within full scale."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import recording_simulation

RATE = 16000


def syllables(seconds: float = 6.0, seed: int = 0) -> np.ndarray:
    """Bursts of filtered noise and harmonics at uneven times: like speech, nowhere like itself elsewhere."""
    random = np.random.default_rng(seed)
    time = np.arange(int(seconds * RATE)) / RATE
    audio = np.zeros(len(time))
    for begin in np.cumsum(random.uniform(0.12, 0.4, int(seconds * 3))):
        shape = np.exp(-0.5 * ((time - begin) / 0.04) ** 2)
        pitch = random.uniform(100, 220)
        tones = sum(np.sin(2 * np.pi * pitch * k * time + random.uniform(0, 6)) / k for k in range(1, 16))
        audio += shape * (tones + 0.3 * random.normal(size=len(time)))
    return audio / np.abs(audio).max() * 0.8


def power(audio: np.ndarray, low: float, high: float) -> float:
    """Decibels between two frequencies (Hz)."""
    spectrum = np.abs(np.fft.rfft(audio)) ** 2
    hertz = np.fft.rfftfreq(len(audio), 1 / RATE)
    return float(10 * np.log10(spectrum[(hertz >= low) & (hertz < high)].sum() + 1e-12))


def lags(audio: np.ndarray, original: np.ndarray) -> list[int]:
    """By how many samples each second of ``audio`` comes after the original."""
    from scipy.signal import correlate

    found = []
    for begin in range(RATE // 2, len(original) - 2 * RATE, RATE):
        piece = original[begin : begin + RATE]
        likeness = correlate(audio[begin - 300 : begin + RATE + 300], piece, "valid", "fft")
        found.append(int(np.argmax(likeness)) - 300)
    return found


@pytest.mark.parametrize("name", recording_simulation.CODECS)
def test_codecs_leave_words_in_their_place(name):
    av = pytest.importorskip("av")
    if recording_simulation.CODECS[name][1] not in av.codecs_available:
        pytest.skip(f"this PyAV has no {name}")
    original = syllables()
    for kilobits in recording_simulation.CODECS[name][2]:
        heard = recording_simulation.apply_codec(original, name, kilobits)
        assert heard.shape == original.shape
        assert max(map(abs, lags(heard, original))) <= 1
        assert np.corrcoef(heard, original)[0, 1] > 0.9
        # lossy indeed
        assert np.abs(heard - original).max() > 1e-3


def test_codecs_keep_silence_and_short_sounds():
    pytest.importorskip("av")
    assert np.abs(recording_simulation.apply_codec(np.zeros(RATE), "mp3", 32)).max() < 1e-3
    assert recording_simulation.apply_codec(syllables(1.0)[:3000], "aac", 32).shape == (3000,)


def test_a_telephone_leaves_out_bass_and_treble_and_keeps_time():
    original = np.random.default_rng(0).normal(size=4 * RATE) * 0.1 + syllables(4.0)
    heard = recording_simulation.simulate_telephone(original)
    assert heard.shape == original.shape and max(map(abs, lags(heard, original))) == 0
    assert power(heard, 4100, 8000) < power(original, 4100, 8000) - 30
    assert power(heard, 20, 150) < power(original, 20, 150) - 20
    assert power(heard, 500, 3000) == pytest.approx(power(original, 500, 3000), abs=1)


@pytest.mark.parametrize("low, high", [(200, None), (None, 4000)])
def test_a_band_removes_what_is_outside(low, high):
    original = np.random.default_rng(1).normal(size=2 * RATE)
    heard = recording_simulation.band_pass(original, low, high)
    outside = (10, 70) if low else (6500, 8000)
    assert power(heard, *outside) < power(original, *outside) - 30
    assert power(heard, 500, 3000) == pytest.approx(power(original, 500, 3000), abs=0.5)


def test_clipping_flattens_only_the_loudest():
    original = syllables()
    heard = recording_simulation.clip_loudest(original, 0.02)
    changed = heard != original
    assert 0.001 < changed.mean() < 0.03 and np.abs(heard).max() < np.abs(original).max()
    np.testing.assert_allclose(np.abs(heard[changed]), np.abs(heard).max())


def test_recordings_differ_repeat_stay_in_place_and_a_quarter_is_nearly_clean():
    pytest.importorskip("av")
    original = syllables(4.0)
    clean = 0
    for seed in range(40):
        heard = recording_simulation.simulate_recording(original, np.random.default_rng(seed))
        assert heard.shape == original.shape and np.isfinite(heard).all() and 0.1 < np.abs(heard).max() <= 1
        assert max(map(abs, lags(heard, original))) <= 3
        if seed < 3:
            np.testing.assert_array_equal(heard, recording_simulation.simulate_recording(original, np.random.default_rng(seed)))
        clean += np.corrcoef(heard, original)[0, 1] > 0.995
    assert 6 <= clean <= 22
