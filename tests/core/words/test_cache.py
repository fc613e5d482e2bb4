import json
import os

import pytest
from s2ag.core.sound import audio
from s2ag.core.words import align, transcript
from s2ag.core.words.cache import Cache, cache_key, default_folder


@pytest.fixture(scope="module")
def sound(examples):
    return audio.load(examples / "hello.flac")


@pytest.fixture
def counted(monkeypatch):
    """Calls of the aligner."""
    calls, real = [], align.align_stretches
    monkeypatch.setattr(align, "align_stretches", lambda *arguments: calls.append(1) or real(*arguments))
    return calls


def test_the_same_again_is_not_aligned_again(sound, examples, tmp_path, counted):
    pytest.importorskip("pocketsphinx")
    ways, text = transcript.TranscriptOptions(Cache(tmp_path / "kept")), (examples / "hello.txt").read_text()
    first = transcript.timed_transcript(sound, text=text, ways=ways)
    assert transcript.timed_transcript(sound, text=text, ways=ways) == first and len(counted) == 1
    with_marks = text.replace("hands", "*hands* [laughs]").replace("When", "{none} When")
    assert transcript.timed_transcript(sound, text=with_marks, ways=ways).words == first.words and len(counted) == 1
    transcript.timed_transcript(sound[:-800], text=text, ways=ways)
    transcript.timed_transcript(sound, text=text + " Indeed.", ways=ways)
    assert len(counted) == 3
    assert sorted(path.suffix for path in (tmp_path / "kept").iterdir()) == [".json"] * 3


LITTLE = '{"spans": [[0]], "confidence": [], "complaint": ""}'
BAD = json.dumps({"spans": [[2, 1]] * 35, "confidence": [{}] * 35, "complaint": 3})


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"spans": 3}', LITTLE, BAD, "[" * 9999])
def test_a_damaged_file_is_made_again(sound, examples, tmp_path, counted, damage):
    pytest.importorskip("pocketsphinx")
    ways = transcript.TranscriptOptions(Cache(tmp_path))
    first = transcript.timed_transcript(sound, examples / "hello.txt", ways=ways)
    (path,) = tmp_path.iterdir()
    path.write_text(damage)
    assert transcript.timed_transcript(sound, examples / "hello.txt", ways=ways) == first and len(counted) == 2
    assert json.loads(path.read_text())[0]["spans"]


@pytest.mark.parametrize("damage", ["[[1,2,3,4]]", "[[]]", '[["a", 2, 1, 0]]', '[["a", null, 1, 0]]', "[3]", "[" * 9999])
def test_what_the_recogniser_heard_is_heard_again_if_it_is_damaged(sound, tmp_path, monkeypatch, damage):
    """The recogniser itself is not asked: this is about what was kept of it."""
    from s2ag.core.words import recognise
    from s2ag.core.words.readers.items import Item

    heard = [Item("so this is what it is", 0.5, 2.0)]
    monkeypatch.setattr(recognise, "recognise", lambda *arguments: list(heard))
    ways = transcript.TranscriptOptions(Cache(tmp_path), recognise=True)
    assert transcript._recognise(sound, None, ways) == heard
    (path,) = tmp_path.iterdir()
    path.write_text(damage)
    assert transcript._recognise(sound, None, ways) == heard
    assert json.loads(path.read_text())


def test_a_dead_aligner_is_not_remembered(sound, examples, tmp_path, monkeypatch):
    monkeypatch.setattr(align, "command", lambda: [str(tmp_path / "nothing")])
    transcript.timed_transcript(sound, examples / "hello.txt", ways=transcript.TranscriptOptions(Cache(tmp_path)))
    assert not list(tmp_path.iterdir())


def test_the_least_recently_used_goes_first(tmp_path):
    cache = Cache(tmp_path, limit=500)
    for number in range(5):
        cache.put(f"{number}", "x" * 98)
        os.utime(tmp_path / f"{number}.words.json", (number, number))
        cache.get("0")
    assert cache.get("0") and cache.get("4") and cache.get("1") is None
    files, size = cache.size()
    assert files == 3 and size == 3 * 145 <= 500
    (tmp_path / "notes.txt").write_text("of the user")
    assert cache.clear() == 3 and cache.size() == (0, 0) and (tmp_path / "notes.txt").exists()


def test_where_it_is(tmp_path, monkeypatch):
    platformdirs = pytest.importorskip("platformdirs")
    monkeypatch.delenv("S2AG_CACHE", raising=False)
    assert default_folder().is_relative_to(platformdirs.user_cache_dir("s2ag", appauthor=False))
    monkeypatch.setenv("S2AG_CACHE", str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.setenv("S2AG_CACHE", "off")
    assert default_folder() is None and Cache(None).get("a") is None
    Cache(None).put("a", 1)


def test_a_folder_that_cannot_be_written_is_told_and_harms_nothing(sound, examples, tmp_path):
    pytest.importorskip("pocketsphinx")
    (tmp_path / "file").write_text("")
    found = transcript.timed_transcript(
        sound, examples / "hello.txt", ways=transcript.TranscriptOptions(Cache(tmp_path / "file" / "kept"))
    )
    assert len(found.words) == 41 and len(found.warnings) == 1 and "cannot be kept" in found.warnings[0]


def _others(value):
    """JSON values of the same form with zeros, other times, and truth values for numbers."""
    for change in (lambda number: 0, lambda number: 100 * number, lambda number: True, str):
        yield json.loads(json.dumps(value), parse_float=lambda text, change=change: change(float(text)))


def test_an_entry_counts_as_it_was_written_or_not_at_all(tmp_path):
    cache, value = Cache(tmp_path), {"spans": [[0.25, 0.5]], "confidence": [0.75], "phones": [[["AA", 0.25, 0.5]]]}
    cache.put("a", value)
    assert cache.get("a") == value
    (path,) = tmp_path.glob("*.words.json")
    kept = json.loads(path.read_text())
    for other in (*_others(kept), value, [value], [value, ""], 3, None):
        path.write_text(json.dumps(other))
        assert cache.get("a") is None
    (tmp_path / "b.words.json").write_text(json.dumps(kept))
    assert cache.get("b") is None


def test_keys_differ_with_everything():
    assert len({cache_key("a", [1]), cache_key("a", [2]), cache_key("b", [1]), cache_key("a", ["1"])}) == 4
