"""The vocabulary is data: what it finds in words, what a user adds, and what is refused in a sentence."""

import json

import numpy as np
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


def test_a_user_adds_phrases_to_a_gesture_that_is_known(tmp_path):
    both = vocabulary.load_vocabulary(write(tmp_path / "own.json", {"gestures": {"rise": {"says": ["no way up", "no way"]}}}))
    assert both.find(["no", "way", "up"]) == {2: ("rise", 3, 2)}
    assert both.find(["no", "way"], [True, False]) == {}
    np.testing.assert_array_equal(both.gestures["rise"].path, vocabulary.load_vocabulary().gestures["rise"].path)


def test_every_gesture_has_two_forms_that_differ(known):
    for name, forms in known.forms.items():
        assert len(forms) > 1 or name in ("contrast", "step"), name
        ends = [np.concatenate([form.path[0], form.path[-1]]) for form in forms]
        fingers = [None if form.shape is None else form.shape[-1] for form in forms]
        for k in range(1, len(forms)):
            arms = forms[k].arms != forms[0].arms
            bends = fingers[k] is not None and np.abs(fingers[k] - fingers[0]).max() > 10
            palms = np.abs(forms[k].palm[-1] - forms[0].palm[-1]).max() > 0.3
            assert np.abs(ends[k] - ends[0]).max() > 0.1 or bends or palms or arms, name


def test_a_user_adds_words_phrases_and_handshapes(tmp_path):
    mine = {"says": ["abracadabra"], "marks": ["magic"], "shape": "claw", **POSES}
    path = write(tmp_path / "Wörter.json", {"gestures": {"magic": mine}, "shapes": {"claw": [30] * 12}})
    both = vocabulary.load_vocabulary(path)
    assert both.find(["abracadabra"], [False]) == {0: ("magic", 1, 0)}
    assert both.marks["magic"] == "magic"
    assert both.gestures["magic"].shape.shape == (1, 12)


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
