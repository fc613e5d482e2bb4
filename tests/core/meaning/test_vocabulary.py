"""The vocabulary is data: what it finds in words, what a user adds, and what is refused in a sentence."""

import json

import pytest
from s2ag.core.errors import UsageError
from s2ag.core.meaning import vocabulary

POSES = {"ready": [[-0.2, 0.9, 0.3], [0, 0.5, 0.8]], "stroke": [[-0.2, 0.9, 0.3], [0, -0.5, 0.8]]}


@pytest.fixture(scope="module")
def known():
    return vocabulary.load_vocabulary()


def write(path, content):
    path.write_text(json.dumps(content), "utf-8")
    return path


@pytest.mark.parametrize(
    ("said", "bearer", "gesture"),
    [
        ("well i don't know anything", 3, "shrug"),
        ("it was this big", 3, "big"),
        ("no never", 0, "negation"),
        ("no way", 1, "refusal"),
        ("first of all we eat", 2, "one"),
        ("on the other hand it rains", 3, "contrast"),
        ("it is over there", 3, "there"),
        ("why not", 1, "question"),
    ],
)
def test_phrases_are_found_at_the_word_that_bears_them(known, said, bearer, gesture):
    words = said.split()
    assert known.find(words, [False] * len(words))[bearer][0] == gesture


def test_longer_phrases_win_and_no_word_is_in_two(known):
    words = ["no", "way"]
    assert [name for name, _ in known.find(words, [False] * 2).values()] == ["refusal"]


def test_a_phrase_does_not_reach_over_the_end_of_a_sentence(known):
    words = ["no", "way"]
    found = known.find(words, [True, False])
    assert found == {0: ("negation", 1)}


def test_a_user_adds_words_phrases_and_handshapes(tmp_path):
    mine = {"says": ["abracadabra"], "marks": ["magic"], "shape": "claw", **POSES}
    path = write(tmp_path / "Wörter.json", {"gestures": {"magic": mine}, "shapes": {"claw": [30] * 12}})
    both = vocabulary.load_vocabulary(path)
    assert both.find(["abracadabra"], [False]) == {0: ("magic", 1)}
    assert both.marks["magic"] == "magic"
    assert both.gestures["magic"].shape.shape == (12,)
    assert both.find(["huge"], [False]) == {0: ("big", 1)}


@pytest.mark.parametrize(
    "content",
    [
        [],
        {"words": {}},
        {"gestures": []},
        {"gestures": {"a": 1}},
        {"gestures": {"a": {**POSES, "colour": 1}}},
        {"gestures": {"a": {"ready": POSES["ready"]}}},
        {"gestures": {"a": {**POSES, "stroke": [[0, 0, 0], [0, 0, 1]]}}},
        {"gestures": {"a": {**POSES, "stroke": "up"}}},
        {"gestures": {"a": {**POSES, "arms": "three"}}},
        {"gestures": {"a": {**POSES, "shape": "none such"}}},
        {"gestures": {"a": {**POSES, "shake": 400}}},
        {"gestures": {"a": {**POSES, "often": True}}},
        {"gestures": {"a": {**POSES, "says": "no list"}}},
        {"gestures": {"a": {**POSES, "says": [" * "]}}},
        {"gestures": {"a": {"clip": "absent.npz"}}},
        {"gestures": {"a": {"clip": "../own.json"}}},
        {"gestures": {"a": {"clip": "own.json"}}},
        {"gestures": {"a": {"clip": 3}}},
        {"shapes": {"s": [1, 2]}},
        {"shapes": {"s": [1e999] * 12}},
    ],
)
def test_what_is_no_vocabulary_is_refused_in_a_sentence(tmp_path, content):
    with pytest.raises(UsageError, match="not usable"):
        vocabulary.load_vocabulary(write(tmp_path / "own.json", content))


def test_damaged_and_absent_files_are_refused_in_a_sentence(tmp_path):
    (tmp_path / "own.json").write_text("[" * 100_000)
    with pytest.raises(UsageError, match="not usable"):
        vocabulary.load_vocabulary(tmp_path / "own.json")
    (tmp_path / "own.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="not usable"):
        vocabulary.load_vocabulary(tmp_path / "own.json")
    with pytest.raises(UsageError, match="cannot be read"):
        vocabulary.load_vocabulary(tmp_path / "absent.json")
