import json

import numpy as np
import pytest
from s2ag.core.sound import audio, voice_activity
from sounds import pauses


@pytest.fixture(scope="module")
def speech(examples):
    """A recording and, per 10 ms, whether a word is being said."""
    sound = audio.load(examples / "hello.flac")
    said = np.zeros(len(sound) // 160, bool)
    for _, start, end in json.loads((examples / "hello.json").read_text()):
        said[int(start * 100) : int(end * 100)] = True
    return sound, said


def noisy(sound, decibels, seed=0):
    """White noise ``decibels`` below the active speech level."""
    level = audio.SPEECH_RMS / audio.speech_gain(sound)
    hiss = np.random.default_rng(seed).normal(0, level * 10 ** (-decibels / 20), len(sound))
    return (sound + hiss).astype(np.float32)


def voiced_fraction(sound):
    """The voiced fraction of each pose frame."""
    return voice_activity.fraction_per_frame(voice_activity.probability(sound), voice_activity.frame_count(sound))


@pytest.mark.parametrize(("decibels", "hits", "false"), [(None, 0.98, 0.35), (20, 0.95, 0.3), (10, 0.85, 0.25)])
def test_hears_words_and_pauses(speech, decibels, hits, false):
    sound, said = speech
    heard = voice_activity.probability(sound if decibels is None else noisy(sound, decibels)) >= 0.5
    assert heard[said].mean() > hits
    assert heard[~said].mean() < false


@pytest.mark.parametrize("factor", [0.003, 30.0])
def test_gain_does_not_matter(speech, factor):
    sound, _ = speech
    np.testing.assert_allclose(
        voiced_fraction(sound * np.float32(factor)), voiced_fraction(sound), atol=0.02
    )


def test_blocks_do_not_matter_to_the_bit(speech, monkeypatch):
    sound, _ = speech
    heard = voice_activity.probability(sound)
    for size in (len(sound), 101):
        monkeypatch.setattr(voice_activity, "_BLOCK", size)
        assert np.array_equal(voice_activity.probability(sound), heard)


def test_phrases_begin_where_they_begin(speech, examples):
    sound, _ = speech
    words = json.loads((examples / "hello.json").read_text())
    starts = [start for start, _ in voice_activity.segments(sound)]
    phrases = [word[1] for previous, word in zip([["", -1, -1], *words], words, strict=False) if word[1] - previous[2] > 0.35]
    assert len(phrases) >= 4
    for phrase in phrases:
        assert min(abs(start - phrase) for start in starts) < 0.1


@pytest.mark.parametrize(
    "sound",
    [
        np.zeros(160_000),
        np.random.default_rng(0).normal(0, 0.02, 480_000),
        np.random.default_rng(1).normal(0, 1e-5, 160_000),
        np.random.default_rng(2).integers(-1, 2, 160_000) / 32768,
    ],
    ids=["digital silence", "noise", "faint noise", "dither"],
)
def test_nobody_speaks(sound):
    sound = sound.astype(np.float32)
    assert voiced_fraction(sound).max() < 0.4
    assert voice_activity.segments(sound) == []
    assert pauses(sound) == [(0.0, len(sound) / 16000)]


def test_digital_silence_is_exactly_zero():
    assert not voiced_fraction(np.zeros(50_000, np.float32)).any()


def test_digital_silence_around_speech(speech):
    sound, _ = speech
    silence = np.zeros(5 * 16000, np.float32)
    active = voiced_fraction(np.concatenate([silence, sound, silence]))
    assert not active[:70].any() and not active[-70:].any()
    assert active.sum() == pytest.approx(voiced_fraction(sound).sum(), rel=0.05)


@pytest.mark.parametrize("samples", [1, 159, 1066, 1067, 16000, 36267])
def test_frames(samples):
    active = voiced_fraction(np.ones(samples, np.float32))
    assert active.shape == (voice_activity.frame_count(np.ones(samples)),) == (max(1, samples * 15 // 16000),)
    assert active.dtype == np.float32


def test_segments_and_pauses_share_the_time(speech):
    sound, _ = speech
    edges = sorted([*voice_activity.segments(sound, shortest=0), *pauses(sound)])
    assert edges[0][0] == 0 and edges[-1][1] == pytest.approx(len(sound) / 16000)
    assert all(end <= start + 1e-9 for (_, end), (start, _) in zip(edges, edges[1:], strict=False))


def test_stretches_bridge_gaps_and_drop_specks():
    track = np.zeros(500, np.float32)
    track[100:150] = track[160:200] = track[300:305] = track[400:500] = 1
    assert voice_activity.segments_of_track(track) == [(1.0, 2.0), (4.0, 5.0)]
