"""Prosody on made sounds whose accents, pitch and pauses are known."""

import tracemalloc

import numpy as np
import pytest
from s2ag.core.sound import prosody

RATE = 16000


def syllable(seconds: float, hertz: float, loud: float) -> np.ndarray:
    """A vowel: harmonics of ``hertz`` under a soft envelope."""
    time = np.arange(int(seconds * RATE)) / RATE
    tone = sum(np.sin(2 * np.pi * hertz * k * time) / k for k in range(1, 12))
    return loud * np.hanning(len(time)) ** 0.5 * tone


def talk(loud=(0.1, 0.1, 0.3, 0.1), pitch=(120, 120, 150, 120), phrases: int = 3, pause: float = 0.8):
    """Phrases of syllables with words for them: ``(audio, words)``; the strongest syllable is the third."""
    random = np.random.default_rng(0)
    pieces, words, at = [np.zeros(RATE // 2)], [], 0.5
    for _ in range(phrases):
        for number, (level, hertz) in enumerate(zip(loud, pitch, strict=True)):
            length = 0.3 if level == max(loud) else 0.2
            pieces += [syllable(length, hertz, level), np.zeros(int(0.05 * RATE))]
            words.append((("the", "table", "mountain", "window")[number], at, at + length))
            at += length + 0.05
        pieces.append(np.zeros(int(pause * RATE)))
        at += pause
    audio = np.concatenate(pieces)
    return (audio + 1e-4 * random.normal(size=len(audio))).astype(np.float32), words


@pytest.mark.parametrize("known", [True, False])
def test_the_loudest_highest_syllable_of_every_phrase_is_its_main_accent(known):
    audio, words = talk()
    found = prosody.analyse(audio, words if known else ())
    assert len(found.phrases) == 3
    mains = [accent for accent in found.accents if accent.main]
    assert len(mains) == 3 and [accent.phrase for accent in mains] == [0, 1, 2]
    for accent, (_, start, end) in zip(mains, words[2::4], strict=True):
        assert start <= accent.time <= end
        assert accent.strength > 0.5
    if known:
        assert all(words[accent.word][0] == "mountain" for accent in mains)
        assert max(accent.strength for accent in found.accents if words[accent.word][0] == "the") < 0.3


def test_features_mark_accents_phrases_and_pauses():
    audio, words = talk()
    found = prosody.analyse(audio, words)
    column = dict(zip(prosody.FEATURE_NAMES, found.features.T, strict=True))
    assert found.features.shape == (int(len(audio) / RATE * 15), prosody.FEATURES) and found.features.dtype == np.float32
    for accent in (accent for accent in found.accents if accent.main):
        frame = round(accent.time * 15)
        assert column["main accent"][frame] > 0.5 * accent.strength
        assert column["until main accent"][frame - 3] > 0.6 > 0.3 > column["until main accent"][frame + 2]
    quiet = np.array([not (found.phrases[:, 0] - 0.1 < t).any() for t in np.arange(len(audio) * 15 // RATE) / 15])
    assert (column["pause"][quiet] > 0).all() and (column["voice"][quiet] < 0.1).all()
    assert np.abs(found.features).max() < 6


def test_a_higher_livelier_voice_has_a_higher_register_and_range():
    calm, words = talk(pitch=(110, 112, 115, 110))
    lively, _ = talk(pitch=(180, 240, 320, 160))
    columns = [
        dict(zip(prosody.FEATURE_NAMES, prosody.analyse(x, words).features.mean(0), strict=True)) for x in (calm, lively)
    ]
    assert columns[1]["register"] > columns[0]["register"] + 1
    assert columns[1]["pitch range"] > columns[0]["pitch range"] + 1


def test_recording_level_does_not_matter_much():
    audio, words = talk()
    loud, quiet = (prosody.analyse(audio * gain, words) for gain in (1.0, 0.1))
    assert [a.main for a in loud.accents] == [a.main for a in quiet.accents]
    np.testing.assert_allclose(loud.features, quiet.features, atol=0.3)


def test_a_long_phrase_is_cut():
    bursts = [piece for _ in range(44) for piece in (syllable(0.2, 120, 0.2), np.zeros(int(0.05 * RATE)))]
    found = prosody.analyse(np.concatenate([np.zeros(RATE), *bursts, np.zeros(RATE)]).astype(np.float32))
    lengths = found.phrases[:, 1] - found.phrases[:, 0]
    assert len(lengths) >= 3 and lengths.max() <= prosody.LONGEST_PHRASE + 0.1


@pytest.mark.parametrize("samples", [0, 10, 1600, 32000])
def test_silence_and_scraps_have_features_but_no_accents(samples):
    found = prosody.analyse(np.zeros(samples, np.float32), frames=9)
    assert found.features.shape == (9, prosody.FEATURES) and np.isfinite(found.features).all()
    assert not found.accents and len(found.phrases) == 0


def test_words_without_sound_still_give_finite_features():
    found = prosody.analyse(np.zeros(16000, np.float32), [("hello", 0.1, 0.4), ("there", 0.9, 3.0)])
    assert np.isfinite(found.features).all()


def test_memory_does_not_grow_with_bands_of_the_whole_recording():
    audio = np.random.default_rng(0).normal(0, 0.1, 240 * RATE).astype(np.float32)
    tracemalloc.start()
    prosody.analyse(audio[: 120 * RATE])
    short = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    prosody.analyse(audio)
    assert tracemalloc.get_traced_memory()[1] - short < 4 * audio[: 120 * RATE].nbytes
    tracemalloc.stop()
