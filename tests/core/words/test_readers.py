"""Transcripts in the forms people have."""

import json

import pytest
from s2ag.core.errors import TranscriptUnreadable
from s2ag.core.words import readers, transcript
from transcripts import FORMS, GENTLE, WHISPERX, WORDS, YOUTUBE_FILE, as_json, google


def read(path):
    return readers.parse(transcript.read_text(path), path)


@pytest.mark.parametrize(("name", "write", "form", "expected"), [row[1:] for row in FORMS], ids=[row[0] for row in FORMS])
def test_every_form(tmp_path, name, write, form, expected):
    path = tmp_path / name
    write(path)
    source, stated_ends = read(path), write is not YOUTUBE_FILE
    assert source.form == form
    assert [item.text.split() for item in source.items] == [words.split() for words, _, _ in expected]
    assert all(item.word == (expected is WORDS) for item in source.items)
    for item, (_, start, end) in zip(source.items, expected, strict=True):
        assert item.start == (start if start is None else pytest.approx(start, abs=1e-3))
        if stated_ends:
            assert item.end == (end if end is None else pytest.approx(end, abs=1e-3))


@pytest.mark.parametrize(("name", "write", "form", "expected"), [row[1:] for row in FORMS], ids=[row[0] for row in FORMS])
def test_the_content_decides_and_not_the_suffix(tmp_path, name, write, form, expected):
    write(tmp_path / name)
    path = (tmp_path / name).rename(tmp_path / "words.transcript")
    assert read(path).form == form


def test_gentles_words_without_times_keep_their_place(tmp_path):
    data = json.loads(json.dumps(GENTLE))
    data["words"][1] = {"case": "not-found-in-audio", "startOffset": 4, "endOffset": 8, "word": "then,"}
    as_json(data)(tmp_path / "a.json")
    items = read(tmp_path / "a.json").items
    assert [item.text for item in items] == [word for word, _, _ in WORDS]
    assert items[1].start is None and not items[1].word


def test_numbers_without_times_in_whisperx(tmp_path):
    data = json.loads(json.dumps(WHISPERX))
    data["segments"][0]["words"][1] = {"word": "42"}
    as_json(data)(tmp_path / "a.json")
    assert [(item.text, item.word) for item in read(tmp_path / "a.json").items][1] == ("42", False)


def test_google_repeats_all_words_with_speaker_labels(tmp_path):
    results = google("startTime", "endTime", lambda t: f"{t:.3f}s")
    words = [word for result in results for word in result["alternatives"][0]["words"]]
    results.append({"alternatives": [{"words": [{**word, "speakerTag": 1} for word in words]}]})
    as_json({"results": results})(tmp_path / "a.json")
    assert [item.text for item in read(tmp_path / "a.json").items] == [word for word, _, _ in WORDS]


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.json", '{"segments": [{"text": "so", "start": 2, "end": 1}]}', "sensible time"),
        ("a.json", '{"segments": [{"words": [{"word": "so", "start": -1, "end": 1}]}]}', "sensible time"),
        ("a.json", '{"results": [{"alternatives": [{"words": [{"word": "so", "startTime": "x", "endTime": "1s"}]}]}]}', "time"),
        ("a.json", '{"tiers": {"words": {"entries": [[0, 1]]}}}', "start, end and label"),
        ("a.json", '{"hello": 1}', "no list of words"),
        ("a.TextGrid", 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n0\n1\n<exists>\n1\n"Interv', "TextGrid"),
        ("a.TextGrid", 'File type = "ooTextFile"\nObject class = "TextGrid"\n\nxmin = 0\n', "TextGrid"),
        ("a.ttml", '<?xml version="1.0"?><tt><body/></tt>', "XML"),
        ("a.tsv", "start\tend\ttext\n5\tso\n", "start, end and text"),
        ("a.csv", "Begin,End,Label,Type,Speaker\nx,y,so,words,a\n", "begin, end and label"),
    ],
)
def test_damaged_files_say_what_is_wrong(tmp_path, name, content, says):
    (tmp_path / name).write_text(content)
    with pytest.raises(TranscriptUnreadable, match=says) as caught:
        read(tmp_path / name)
    assert str(tmp_path / name) in caught.value.message and "\n" not in caught.value.message and caught.value.remedy


@pytest.mark.parametrize("content", ["[laughs] Well, hello.", "{me} I think so.", "[pause]", "12 --> 13", "(sighs) [so]", ""])
def test_what_only_looks_like_another_form_is_plain_text(tmp_path, content):
    (tmp_path / "a.txt").write_text(content)
    assert read(tmp_path / "a.txt").form == "plain text"
