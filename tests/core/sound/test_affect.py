"""Affect in voices: people who act, people who read, and sounds that are no voice."""

import tracemalloc
import warnings

import numpy as np
import pytest
from s2ag.core.learning.corpus.human_speech import levelled
from s2ag.core.sound import affect, audio, resample, speech_units, voice_quality, word_affect
from s2ag.core.vectors.table import WordVectors
from sounds import bandpasses

RATE = 16000


def hear(sound, *more):
    """Affect of all frames; warnings are errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return affect.hear(sound, int(len(sound) / RATE * 15), *more)


@pytest.fixture(scope="module")
def acted(shared):
    """One sentence acted by one man, by the way."""
    return {path.stem: audio.load(path) for path in sorted((shared / "thorsten_emotional").glob("*.wav"))}


@pytest.fixture(scope="module")
def sonnet(shared):
    return audio.load(shared / "speech" / "p001.mp3")


def again(sound, rate):
    """The sound as a device with another sampling rate keeps it."""
    coarse = np.concatenate(list(resample.resample(iter([sound]), RATE, rate)))
    return np.concatenate(list(resample.resample(iter([coarse]), rate, RATE))).astype(np.float32)


def noisy(sound, decibels):
    power = np.sqrt(np.mean(sound**2)) * 10 ** (-decibels / 20)
    return (sound + power * np.random.default_rng(0).normal(size=len(sound))).astype(np.float32)


PLACES = {
    "as it is": lambda sound: sound,
    "20 dB louder": lambda sound: 10 * sound,
    "20 dB softer": lambda sound: 0.1 * sound,
    "noise 10 dB below": lambda sound: noisy(sound, 10),
    "11 kHz": lambda sound: again(sound, 11025),
    "telephone": lambda sound: bandpasses(sound, ((300, 3400),))[0].astype(np.float32),
}


@pytest.mark.parametrize("place", PLACES)
def test_anger_is_above_neutral_and_that_above_sleep_wherever_it_is_recorded(acted, place):
    arousal = {name: hear(PLACES[place](acted[name]))[:, 0].mean() for name in ("angry", "neutral", "sleepy", "surprised")}
    assert arousal["angry"] > arousal["neutral"] + 0.2
    assert min(arousal["neutral"], arousal["surprised"]) > arousal["sleepy"] + 0.2


def test_level_does_not_count(acted):
    for sound in acted.values():
        np.testing.assert_allclose(hear(0.1 * sound), hear(sound), atol=1e-3)


def test_readers_are_ordinary(shared, sonnet):
    kathleen = [audio.load(path) for path in sorted((shared / "kathleen").glob("*.opus"))[::50]]
    for sound in sonnet, audio.load(shared / "speech" / "p002.mp3"), np.concatenate(kathleen):
        assert np.abs(hear(sound).mean(0)).max() < 0.35


def test_an_angry_sentence_is_heard_after_a_long_reading(acted, sonnet):
    pause = np.zeros(RATE // 2, np.float32)
    parts = [sonnet, acted["angry"], pause, acted["sleepy"]]
    parts = [levelled(part) if part.any() else part for part in parts]
    heard = hear(np.concatenate(parts))[:, 0]
    edges = (np.cumsum([len(part) for part in parts]) / RATE * 15).astype(int)
    reading, angry, sleepy = (heard[: edges[0]], heard[edges[0] + 15 : edges[1]], heard[edges[2] + 8 :])
    assert angry.mean() > reading.mean() + 0.5 and angry.mean() > 0.4
    assert sleepy.mean() < reading.mean() - 0.3


def after(sound, line):
    """A line after 25 s of another recording and half a second of nothing, and the second at which it begins."""
    parts = levelled(sound[: 25 * RATE]), np.zeros(RATE // 2, np.float32), levelled(line)
    return np.concatenate(parts), 25.5


def test_another_voice_on_another_microphone_does_not_move_a_line(acted, sonnet):
    alone, later = {}, {}
    for name in ("amused", "angry"):
        alone[name] = hear(acted[name])[:, 1].mean()
        sound, begins = after(sonnet, acted[name])
        later[name] = hear(sound)[int(begins * 15) :, 1].mean()
    assert alone["amused"] > alone["angry"] + 0.3 and later["amused"] > later["angry"] + 0.3
    # moved by 2 deviations as the noisy reading is, both would be heard as pleased
    assert later["angry"] < 0 < later["amused"]


def test_noise_of_one_recording_is_not_taken_from_another(acted, sonnet):
    sound, begins = after(sonnet, acted["angry"])
    alone, later = (voice_quality.measure(each) for each in (acted["angry"], sound))
    rows = slice(int(begins * voice_quality.RATE), None)
    both = alone.voiced & later.voiced[rows]
    for name, close in (("harmonicity", 0.1), ("hammarberg", 0.1), ("pitch", 1e-4)):
        np.testing.assert_allclose(getattr(later, name)[rows][both], getattr(alone, name)[both], atol=close)
    reading, noise = (speech_units.measure(each).noise for each in (sonnet[: 25 * RATE], sound))
    assert np.abs(noise[: len(reading)] - reading).max() < 3 and noise[-1] < reading.min() - 10


@pytest.mark.parametrize(
    "sound",
    [
        np.zeros(0, np.float32),
        np.zeros(5 * RATE, np.float32),
        np.full(5 * RATE, 0.3, np.float32),
        np.random.default_rng(0).normal(size=5 * RATE).astype(np.float32),
        np.sin(2 * np.pi * np.arange(5 * RATE)[:, None] / RATE * (220, 277, 330)).sum(1).astype(np.float32),
    ],
    ids=["no sound", "silence", "offset", "noise", "chord"],
)  # fmt: skip
def test_without_a_voice_nothing_is_heard(sound):
    assert not hear(sound).any()


def test_a_whisper_is_calm_and_noise_makes_no_voice_a_whisper(acted):
    arousal = {name: hear(sound)[:, 0].mean() for name, sound in acted.items()}
    assert arousal["sleepy"] < arousal["whisper"] < arousal["neutral"] - 0.3
    for name in ("angry", "drunk", "surprised"):
        assert hear(noisy(acted[name], 5))[:, 0].mean() > arousal["whisper"] + 0.4


def test_creak_is_no_melody_that_pleases():
    def valence(semitones):
        features = affect._CENTRES.copy()[None]
        features[0, speech_units.NAMES.index("range")] = semitones
        units = speech_units.Units(np.array([[0.0, 2.0]]), np.ones(1), features, np.full(1, -50.0))
        return affect.rate(units, np.zeros((1, 2)))[0, 1]

    assert valence(5) < valence(7) < valence(9) and valence(12) == valence(20)


def test_half_a_second_is_enough_to_be_sensible(acted):
    for sound in acted.values():
        heard = hear(sound[12000:20000])
        assert heard.shape == (7, 3) and heard.dtype == np.float32 and np.isfinite(heard).all() and np.abs(heard).max() <= 1
    assert hear(acted["angry"][16000:24000])[:, 0].mean() > hear(acted["sleepy"][16000:24000])[:, 0].mean() + 0.3


def test_a_mood_outlasts_the_voice_and_sinks_in_silence(acted):
    quiet = np.zeros(30 * RATE, np.float32)
    heard = np.abs(hear(np.concatenate([acted["sleepy"], quiet]))[:, 0])
    spoken = int(len(acted["sleepy"]) / RATE * 15)
    assert heard[spoken + 15] > 0.9 * heard[:spoken].max()  # a second later
    assert heard[-1] < 0.1 * heard[:spoken].max() and (np.diff(heard[spoken + 5 :]) <= 0).all()


def test_minutes_of_digital_silence_hold_no_speech_and_no_noise(acted):
    line, silence = acted["angry"], np.zeros(150 * RATE, np.float32)
    alone, before = speech_units.measure(line), speech_units.measure(np.concatenate([line, silence]))
    np.testing.assert_allclose(before.spans, alone.spans, atol=0.02)  # frames at the line's end hear its last samples or none
    np.testing.assert_allclose(before.noise, alone.noise, atol=1.0)
    after = speech_units.measure(np.concatenate([silence, line]))
    np.testing.assert_allclose(after.spans - 150, alone.spans, atol=0.02)


@pytest.mark.slow
def test_an_hour_is_heard_in_bounded_memory(sonnet):
    hour = np.tile(sonnet, -(-3600 * RATE // len(sonnet)))[: 3600 * RATE]
    tracemalloc.start()
    heard = affect.hear(hour, 54000)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert heard.shape == (54000, 3) and np.isfinite(heard).all()
    # 360,000 frames of 25 bytes of tracks; with their copies and a minute's spectra below 80 MB
    assert most < 80e6


def test_words_tell_pleasant_from_unpleasant_where_their_language_is_known(sonnet):
    vectors = WordVectors.load()

    def said(text, known: WordVectors | None = vectors):
        words = [(word, 0.4 * at, 0.4 * at + 0.3) for at, word in enumerate(text.split() * 10)]
        return hear(sonnet, words, known)[: int(len(words) * 0.4 * 15)].mean(0)

    good, bad = said("i love this wonderful happy day"), said("they hate this terrible painful death")
    assert good[1] > bad[1] + 0.5 and good[2] > bad[2]
    assert good[0] == bad[0]
    assert (said("they hate this terrible painful death", None) == said("i love this wonderful happy day", None)).all()


def test_words_say_nothing_where_there_are_none():
    spans = np.array([[0.0, 1.0]])
    assert not word_affect.hear_words([], WordVectors.load(), spans).any()
    assert not word_affect.hear_words([("-", 0.0, 1.0)], WordVectors.load(), spans).any()
