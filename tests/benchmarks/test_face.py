import numpy as np
import pytest
from s2ag.core.face import animation
from s2ag.core.motion import skeleton
from s2ag.core.sound import audio, prosody
from s2ag.core.words import transcript

LIMIT = 0.2
"""Seconds that a face may add to a minute of speech."""


@pytest.mark.benchmark(group="face")
def test_a_minute_of_speech(benchmark, examples):
    sound = audio.load(examples / "hello.flac")
    heard = transcript.timed_transcript(sound, examples / "hello.txt")
    length, copies = len(sound) / audio.SAMPLE_RATE, 4

    def later(spans, number):
        return tuple((name, start + number * length, end + number * length) for name, start, end in spans)

    words = [word for number in range(copies) for word in later(heard.words, number)]
    phones = [later(sounds, number) for number in range(copies) for sounds in heard.phones]
    sound = np.tile(sound, copies)[: 60 * audio.SAMPLE_RATE]
    words, phones = zip(*[pair for pair in zip(words, phones, strict=True) if pair[0][2] < 59.5], strict=True)
    directions = np.repeat(skeleton.REST[None], 900, 0)
    rhythm = prosody.analyse(sound, words)  # which the network hears, too
    benchmark(lambda: animation.make_face(animation.analyse(sound, words, phones, rhythm), directions))
    assert benchmark.stats.stats.min < LIMIT


@pytest.mark.benchmark(group="face")
def test_a_minute_of_speech_by_ear_alone(benchmark, examples):
    sound = np.tile(audio.load(examples / "hello.flac"), 5)[: 60 * audio.SAMPLE_RATE]
    directions = np.repeat(skeleton.REST[None], 900, 0)
    rhythm = prosody.analyse(sound)
    benchmark(lambda: animation.make_face(animation.analyse(sound, rhythm=rhythm), directions))
    assert benchmark.stats.stats.min < LIMIT
