"""Without a transcript: the recogniser where it is installed, a sentence that says how where it is not."""

import importlib.util
import sys

import numpy as np
import pytest
from s2ag.core.errors import EngineMissing, TranscriptUnreadable
from s2ag.core.optional_packages import has_recogniser
from s2ag.core.sound import audio
from s2ag.core.words import recognise, transcript
from s2ag.core.words.cache import Cache
from transcripts import words_and_warnings

needs_recogniser = pytest.mark.skipif(not has_recogniser(), reason="the extra 'recognise' is not installed")


@pytest.fixture(scope="module")
def sound(examples):
    return audio.load(examples / "hello.flac")


@needs_recogniser
def test_speech_becomes_words_with_times(sound, examples, tmp_path, monkeypatch):
    pytest.importorskip("pocketsphinx")
    ways = transcript.TranscriptOptions(Cache(tmp_path), recognise=True)
    found = transcript.timed_transcript(sound, ways=ways)
    assert found.form == "recognised speech" and found.warnings == []
    truth, _ = words_and_warnings(sound, examples / "hello.txt")
    right = {(word.lower(), round(start, 1)) for word, start, _ in truth}
    heard = [(word.lower(), round(start, 1)) for word, start, _ in found.words]
    assert sum(word in right for word in heard) > 0.85 * len(truth)
    monkeypatch.setattr(recognise, "recognise", None)
    assert transcript.timed_transcript(sound, ways=ways) == found, "the second time nobody listens"


@needs_recogniser
def test_silence_holds_no_words():
    found = transcript.timed_transcript(np.zeros(32000, np.float32), ways=transcript.TranscriptOptions(recognise=True))
    assert found.words == () and len(found.warnings) == 1


def test_without_the_extra_the_message_says_how(sound, monkeypatch):
    find = importlib.util.find_spec
    hide = "faster_whisper"
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == hide else find(name, *rest))
    assert not has_recogniser()
    assert transcript.timed_transcript(sound) == transcript.TimedTranscript()
    with pytest.raises(EngineMissing, match=r"s2ag\[recognise\]"):
        transcript.timed_transcript(sound, ways=transcript.TranscriptOptions(recognise=True))


@needs_recogniser
def test_a_folder_without_a_model(sound, tmp_path):
    with pytest.raises(TranscriptUnreadable, match="holds no recogniser"):
        transcript.timed_transcript(sound, ways=transcript.TranscriptOptions(recognise=True, recogniser=tmp_path))
    (tmp_path / "model.bin").write_bytes(b"nothing")
    with pytest.raises(TranscriptUnreadable, match="recogniser died"):
        transcript.timed_transcript(sound, ways=transcript.TranscriptOptions(recognise=True, recogniser=tmp_path))


def test_a_recogniser_that_talks_nonsense(sound, tmp_path, monkeypatch):
    monkeypatch.setattr(recognise, "shipped_model", lambda: tmp_path)
    program = tmp_path / "nonsense.py"
    program.write_text("print('hello', flush=True)")
    monkeypatch.setattr(recognise, "_PROGRAM", program)
    with pytest.raises(TranscriptUnreadable, match="answered nonsense"):
        recognise.recognise(sound)
    assert sys.executable
