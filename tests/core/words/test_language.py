"""An aligner model of the user's own."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.errors import TranscriptUnreadable
from s2ag.core.sound import audio
from s2ag.core.words import align, language, transcript

pocketsphinx = pytest.importorskip("pocketsphinx", reason="the aligner is not installed")
ENGLISH = Path(pocketsphinx.get_model_path()) / "en-us"


@pytest.fixture(scope="module")
def hello(examples):
    return audio.load(examples / "hello.flac"), json.loads((examples / "hello.json").read_text())


@pytest.fixture(scope="module")
def cipher(tmp_path_factory, hello):
    """A language of its own, in Cyrillic: letters are exchanged, sounds are not. Its dictionary lacks every third word."""
    folder = tmp_path_factory.mktemp("cipher")
    shutil.copytree(ENGLISH / "en-us", folder / "acoustic")
    known = dict(line.split(None, 1) for line in (ENGLISH / "cmudict-en-us.dict").read_text().splitlines())
    words = sorted({word.lower() for word, _, _ in hello[1]})
    lines = [f"{written(word)} {known[word]}\n" for number, word in enumerate(words) if number % 3]
    (folder / "cipher.dict").write_text("".join(lines), encoding="utf-8")
    sounds = zip("aeioustrnlhmd", ["AE", "EH", "IH", "OW", "AH", "S", "T", "R", "N", "L", "HH", "M", "D"], strict=True)
    letters = {written(char): sound for char, sound in sounds}
    (folder / "letters.json").write_text(json.dumps(letters), encoding="utf-8")
    return folder


def written(word):
    return "".join(chr(ord("а") + ord(char) - ord("a")) for char in word.lower())


def test_words_of_another_language_are_placed(hello, cipher):
    sound, truth = hello
    text = " ".join(written(word) for word, _, _ in truth)
    ways = transcript.TranscriptOptions(model=language.load_language(cipher))
    found = transcript.timed_transcript(sound, text=text, ways=ways)
    off = np.abs([start - true for (_, start, _), (_, true, _) in zip(found.words, truth, strict=True)])
    assert found.warnings == [] and off.mean() < 0.05
    without = transcript.timed_transcript(sound, text=text)
    assert "Latin letters" in without.warnings[0] and len(without.words) == len(truth)


def test_without_rules_unknown_words_stand_between_their_neighbours(hello, cipher, tmp_path):
    for name in ("acoustic", "cipher.dict"):
        (tmp_path / name).symlink_to(cipher / name)
    sound, truth = hello
    stretch = align.Stretch([[written(word)] for word, _, _ in truth])
    found = align.align_stretches(sound, [stretch], None, language.load_language(tmp_path))
    sure = [number for number, value in enumerate(found.confidence) if value]
    assert 0.4 * len(truth) < len(sure) < len(truth)
    starts = [start for start, _ in found.spans]
    assert starts == sorted(starts)


def test_the_cache_tells_models_apart(cipher, tmp_path):
    model = language.load_language(cipher)
    assert language.fingerprint(None) != language.fingerprint(model) == language.fingerprint(language.load_language(cipher))


def test_folders_that_are_none(tmp_path, cipher):
    with pytest.raises(TranscriptUnreadable, match="is not a folder"):
        language.load_language(tmp_path / "nowhere")
    with pytest.raises(TranscriptUnreadable, match="neither a dictionary nor"):
        language.load_language(tmp_path)
    (tmp_path / "letters.json").write_text("[1]")
    with pytest.raises(TranscriptUnreadable, match="does not map letters"):
        language.load_language(tmp_path)
    (tmp_path / "letters.json").unlink()
    for name in "ab":
        (tmp_path / f"{name}.dict").write_text("")
    with pytest.raises(TranscriptUnreadable, match="2 dictionaries"):
        language.load_language(tmp_path)


def test_a_damaged_model_is_a_warning(hello, tmp_path):
    sound, truth = hello
    (tmp_path / "mdef").write_text("nothing")
    (tmp_path / "a.dict").write_text("hello HH AH L OW\n")
    found = align.align_stretches(
        sound, [align.Stretch([[word] for word, _, _ in truth])], None, language.load_language(tmp_path)
    )
    assert found.complaint.startswith("The aligner died") and len(found.spans) == len(truth)


@pytest.mark.parametrize("content", ['{"a": "' + "A " * 60 + '"}', '{"a": "A"' + " " * 1_000_000 + "}"])
def test_a_letter_is_not_said_at_length(tmp_path, content):
    (tmp_path / "letters.json").write_text(content)
    with pytest.raises(TranscriptUnreadable):
        language.load_language(tmp_path)
