"""Band-pass filters and peaks are scipy's."""

import numpy as np
import pytest
from s2ag.core.smoothing import gaussian
from s2ag.core.sound import audio, peaks
from sounds import bandpasses

signal = pytest.importorskip("scipy.signal", reason="the reference implementation is not installed")


@pytest.mark.parametrize("samples", [1, 5000, 61440, 200_001])
def test_bandpass(samples):
    sound = np.random.default_rng(0).normal(0, 0.1, samples)
    edges = ((200, 1000), (1000, 3400))
    for found, pair in zip(bandpasses(sound, edges), edges, strict=True):
        expected = signal.sosfilt(signal.butter(2, pair, "bandpass", fs=16000, output="sos"), sound)
        assert np.abs(found - expected).max() < 1e-9


@pytest.mark.parametrize("length", [0, 1, 3, 60, 5000])
@pytest.mark.parametrize("digits", [0, 1, 9])
def test_peaks(length, digits):
    """Rounded values have plateaus and heights that come twice."""
    smooth = gaussian(np.random.default_rng(length).normal(0, 20, length), 4)
    values = np.round(smooth, digits)
    near = 8 if digits == 9 else 1  # of equal heights either may push out the other
    places, found = signal.find_peaks(values, prominence=2.0, distance=near)
    ours = peaks.find_peaks(values, 2.0, near, 0.6)
    np.testing.assert_array_equal(ours.places, places)
    np.testing.assert_allclose(ours.prominences, found["prominences"], atol=1e-12)
    np.testing.assert_allclose(ours.widths, signal.peak_widths(values, places, rel_height=0.6)[0], atol=1e-9)


def test_a_band_of_speech(examples):
    sound = audio.load(examples / "hello.flac")
    found = bandpasses(sound, ((200, 1000),))[0]
    expected = signal.sosfilt(signal.butter(2, (200, 1000), "bandpass", fs=16000, output="sos"), sound)
    assert np.abs(found - expected).max() < 1e-9
