"""Pitch on made sounds, and against Praat's own on speech; ``-rP`` prints the differences."""

from pathlib import Path

import numpy as np
import pytest
from s2ag.core.sound import audio, pitch, prosody

LIBRIVOX = Path("/usr/share/pocketsphinx/test/data/librivox")


def praat(sound, rate, step, floor, ceiling):
    """What :func:`pitch.track_pitch` tells, by Praat."""
    parselmouth = pytest.importorskip("parselmouth", reason="the reference implementation is not installed")
    found = parselmouth.Sound(np.asarray(sound, float), rate).to_pitch_ac(
        time_step=step, pitch_floor=floor, pitch_ceiling=ceiling
    )
    return found.xs(), found.selected_array["frequency"]


@pytest.fixture(scope="module")
def recordings(examples):
    found = {"hello": audio.load(examples / "hello.flac")}
    found.update({path.stem[-4:]: audio.load(path) for path in sorted(LIBRIVOX.glob("*.wav"))[:3]})
    noise = np.random.default_rng(0).normal(0, 0.02, len(found["hello"])).astype(np.float32)
    return {**found, "noisy": found["hello"] + noise}


@pytest.mark.parametrize("hertz", [70.0, 123.4, 220.0, 480.0])
def test_a_tone(hertz):
    time = np.arange(16000) / 16000
    voice = sum(np.sin(2 * np.pi * hertz * k * time) / k for k in range(1, 8))
    times, found = pitch.track_pitch(voice, 16000, 0.02, 65.0, 500.0)
    assert len(found) == 48 and times[0] == pytest.approx(1 - times[-1])
    np.testing.assert_allclose(found, hertz, rtol=1e-3)


def test_noise_silence_and_scraps_have_no_pitch():
    for sound in (np.zeros(8000), np.zeros(0), np.ones(300)):
        assert not pitch.track_pitch(sound, 16000, 0.02, 65.0, 500.0)[1].any()
    noise = np.random.default_rng(0).normal(size=32000)
    assert np.mean(pitch.track_pitch(noise, 16000, 0.02, 65.0, 500.0)[1] > 0) < 0.1


def test_equals_praat(recordings):
    frames = voicing = far = 0
    for name, sound in recordings.items():
        times, ours = pitch.track_pitch(sound, 16000, 0.02, 65.0, 500.0)
        expected, theirs = praat(sound, 16000, 0.02, 65.0, 500.0)
        np.testing.assert_allclose(times, expected, atol=1e-9)
        both = (ours > 0) & (theirs > 0)
        cents = 1200 * np.abs(np.log2(ours[both] / theirs[both]))
        print(f"{name}: {np.sum((ours > 0) != (theirs > 0))} of {len(ours)} frames voiced otherwise, ", end="")
        print(f"cents median {np.median(cents):.4f}, 99 % {np.percentile(cents, 99):.3f}, most {cents.max():.1f}")
        frames, voicing = frames + len(ours), voicing + np.sum((ours > 0) != (theirs > 0))
        far += np.sum(cents > 5)
        assert np.median(cents) < 0.1
    assert voicing <= 0.001 * frames and far <= 0.002 * frames


def test_networks_hear_what_they_heard_of_praat(recordings, monkeypatch):
    """The columns of prosody differ by less than what a network could notice, but for a frame of pitch here and there."""
    for name, sound in recordings.items():
        ours = prosody.analyse(sound).features
        with monkeypatch.context() as patch:
            patch.setattr(pitch, "track_pitch", praat)
            theirs = prosody.analyse(sound).features
        off = np.abs(ours - theirs)
        print(f"{name}: mean {off.mean():.1e}, most {off.max():.3f} in {prosody.FEATURE_NAMES[int(off.max(0).argmax())]}")
        assert off.mean() < 1e-3 and np.mean(off > 0.01) < 0.01
