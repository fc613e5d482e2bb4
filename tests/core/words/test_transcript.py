import json

import numpy as np
import pytest
from s2ag.core.errors import TranscriptUnreadable, UsageError
from s2ag.core.sound import audio
from s2ag.core.words import transcript
from transcripts import words_and_warnings


@pytest.fixture(scope="module")
def sound(examples):
    return audio.load(examples / "hello.flac")


def test_plain_text_is_aligned(sound, examples):
    words, warnings = words_and_warnings(sound, examples / "hello.txt")
    assert warnings == []
    assert [word for word, _, _ in words] == [word for word, _, _ in json.loads((examples / "hello.json").read_text())]
    starts = [start for _, start, _ in words]
    assert starts == sorted(starts)
    assert all(0 <= start < end <= len(sound) / 16000 for _, start, end in words)


def test_a_text_and_a_file_give_the_same(sound, examples):
    path = examples / "hello.txt"
    assert words_and_warnings(sound, text=path.read_text()) == words_and_warnings(sound, str(path))


def test_timed_words_are_taken_as_they_are(sound, examples):
    words, warnings = words_and_warnings(sound, examples / "hello.json")
    assert warnings == []
    assert list(map(list, words)) == json.loads((examples / "hello.json").read_text())


@pytest.mark.parametrize(
    "content",
    [
        [["Now", 0.5, 0.7], ["then", 1, 2]],
        {"words": [["Now", 0.5, 0.7], ["then", 1, 2]], "language": "en"},
        {"words": [{"word": " Now", "start": 0.5, "end": 0.7, "score": 1}, {"word": "then", "start": 1, "end": 2}]},
        [["then", 1, 2], ["Now", 0.5, 0.7]],
    ],
)
def test_forms_of_timed_words(sound, tmp_path, content):
    path = tmp_path / "words.JSON"
    path.write_text(json.dumps(content))
    assert words_and_warnings(sound, path) == ((("Now", 0.5, 0.7), ("then", 1.0, 2.0)), [])


def test_timed_words_after_the_end(sound, tmp_path):
    path = tmp_path / "words.json"
    path.write_text(json.dumps([["in", 1, 1.5], ["across", 14, 90], ["after", 90, 91]]))
    words, warnings = words_and_warnings(sound, path)
    assert words == (("in", 1.0, 1.5), ("across", 14.0, len(sound) / 16000))
    assert len(warnings) == 1 and warnings[0].startswith("1 word ")


@pytest.mark.parametrize(
    "content",
    [
        "",
        "{",
        "17",
        '{"text": "so"}',
        '[["so", 1]]',
        '[["so", 2, 1]]',
        '[["so", -1, 1]]',
        '[["so", "0", "1"]]',
        '[["so", NaN, 1]]',
        '[["so", 0, Infinity]]',
        '[["so", true, true]]',
        '[{"word": "so", "start": 1}]',
        "[3]",
        "[" * 100_000,
    ],
)
def test_bad_timed_words_say_what_is_wrong(sound, tmp_path, content):
    path = tmp_path / "words.json"
    path.write_text(content)
    with pytest.raises(TranscriptUnreadable) as caught:
        words_and_warnings(sound, path)
    assert str(path) in caught.value.message and "\n" not in caught.value.message and caught.value.remedy


def test_missing_folder_and_recording_by_mistake(sound, tmp_path, examples):
    for path, says in (
        (tmp_path / "nowhere.txt", "does not exist"),
        (tmp_path, "is a folder"),
        (examples / "hello.flac", "is not a text file"),
    ):
        with pytest.raises(TranscriptUnreadable, match=says):
            words_and_warnings(sound, path)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings(tmp_path, encoding):
    path = tmp_path / "words.txt"
    path.write_bytes("It’s a naïve café".encode(encoding))
    assert transcript.read_text(path) == "It’s a naïve café"


def test_no_words(sound, tmp_path):
    assert words_and_warnings(sound) == ((), [])
    for empty in ("", " \n", "... [laughs] —"):
        words, warnings = words_and_warnings(sound, text=empty)
        assert words == () and len(warnings) == 1 and "sound alone" in warnings[0]
    with pytest.raises(UsageError):
        words_and_warnings(sound, tmp_path / "words.txt", "words")


@pytest.mark.parametrize(
    ("text", "shown", "said"),
    [
        ("“Hello,” she said…", "Hello she said", "hello she said"),
        ("Well-known [laughs] facts (Applause)", "Well-known facts", "well known facts"),
        ("<i>Two</i> for $3!", "Two for $3", "two for three dollars"),
        ("it’s rock--roll (really)", "it’s rock roll really", "it's rock roll really"),
        ("50% — I'd say.", "50% I'd say", "fifty percent i'd say"),
        ("wait...what?", "wait what", "wait what"),
    ],
)
def test_tokens(text, shown, said):
    tokens = transcript.tokenise(text)
    assert " ".join(word for word, _ in tokens) == shown
    assert " ".join(part for _, parts in tokens for part in parts) == said


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "The committee will publish its annual report on fisheries in the northern provinces early next week. " * 2,
            "does not fit",
        ),
        ("Привет, я сделал это для тебя.", "Latin letters"),
        ("So give me your voice, and watch me move! " * 40, "too long"),
    ],
    ids=["another text", "another script", "too long"],
)
def test_a_text_that_does_not_fit_is_spread_over_the_speech(sound, text, says):
    words, warnings = words_and_warnings(sound, text=text)
    assert len(warnings) == 1 and says in warnings[0] and warnings[0].endswith(".")
    assert len(words) == len(text.split())
    assert all(0 <= start <= end <= len(sound) / 16000 for _, start, end in words)


def test_a_text_over_silence(examples):
    words, warnings = words_and_warnings(np.zeros(48000, np.float32), text="nobody says this")
    assert [word for word, _, _ in words] == ["nobody", "says", "this"]
    assert warnings and words[-1][2] <= 3.0
