"""The document of edits: what it takes, what it refuses in a sentence, and that files are read as they were written."""

import json

import pytest
from documents import save_edits
from s2ag.core.editing import edits
from s2ag.core.errors import UsageError

POSE = [[0.0, 1.0, 0.0]] * 9
GOOD = [
    {"do": "move", "at": 1.5, "to": 2.0},
    {"do": "delete", "at": 1},
    {"do": "delete", "at": [1.0, 2.5], "off": True},
    {"do": "rest", "from": 1.0, "to": 4.0},
    {"do": "rest", "from": 1.0, "to": 4.0, "how": "fewer"},
    {"do": "change", "at": 3.0, "kind": "big", "hand": "both", "size": 1.3},
    {"do": "add", "at": 4.0},
    {"do": "add", "word": "huge", "nth": 2, "kind": "big"},
    {"do": "reroll", "from": 1.0, "to": 4.0, "seed": 3},
    {"do": "pose", "at": 2.0, "directions": POSE},
    {"do": "place", "from": 1.0, "to": 2.0, "hand": "left", "place": [-0.3, 0.0, 0.3]},
]
BAD = {
    "no list": {"do": "move"},
    "no object": [3],
    "nothing to do": [{"at": 1.0}],
    "unknown": [{"do": "explode", "at": 1.0}],
    "unhashable": [{"do": ["move"], "at": 1.0}],
    "missing": [{"do": "move", "at": 1.0}],
    "strange key": [{"do": "delete", "at": 1.0, "loud": True}],
    "negative time": [{"do": "delete", "at": -1}],
    "no number": [{"do": "delete", "at": "1"}],
    "truth": [{"do": "delete", "at": True}],
    "not finite": [{"do": "delete", "at": float("nan")}],
    "no times": [{"do": "delete", "at": []}],
    "half off": [{"do": "delete", "at": 1.0, "off": 1}],
    "no rest": [{"do": "rest", "from": 1.0, "to": 4.0, "how": "loud"}],
    "no hand": [{"do": "change", "at": 1.0, "hand": "tail"}],
    "size": [{"do": "change", "at": 1.0, "size": 9}],
    "no change": [{"do": "change", "at": 1.0}],
    "nowhere": [{"do": "add"}],
    "two places": [{"do": "add", "at": 1.0, "word": "so"}],
    "nth of nothing": [{"do": "add", "at": 1.0, "nth": 2}],
    "backwards": [{"do": "reroll", "from": 2.0, "to": 1.0}],
    "half a pose": [{"do": "pose", "at": 2.0, "directions": POSE[:4]}],
    "no direction": [{"do": "pose", "at": 2.0, "directions": [[0, 0, 0]] * 9}],
    "both hands": [{"do": "place", "from": 1.0, "to": 2.0, "hand": "both", "place": [0, 0, 0]}],
    "too many": [{"do": "delete", "at": 1.0}] * (edits.MOST + 1),
}


def test_good_edits_are_taken_as_they_are():
    assert edits.check(GOOD) == GOOD


@pytest.mark.parametrize("case", BAD)
def test_bad_edits_are_refused_in_a_sentence(case):
    with pytest.raises(UsageError) as told:
        edits.check(BAD[case])
    assert told.value.message.endswith(".") and told.value.remedy


def test_the_number_of_the_bad_one_is_told():
    with pytest.raises(UsageError, match="Edit 2 "):
        edits.check([GOOD[0], {"do": "move"}])


def test_a_file_is_read_as_it_was_written(tmp_path):
    save_edits(GOOD, tmp_path / "a.json")
    assert edits.load(tmp_path / "a.json") == GOOD
    save_edits([], tmp_path / "a.json")
    assert edits.load(tmp_path / "a.json") == []


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 2, "edits": []}', json.dumps({"format": 1, "edits": [], "x": 1})])
def test_other_files_are_refused(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(UsageError):
        edits.load(path)
    with pytest.raises(UsageError):
        edits.load(tmp_path / "missing.json")
