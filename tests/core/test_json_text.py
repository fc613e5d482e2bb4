"""JSON of other people: one reader, and every text ends in a value or one sentence."""

import pytest
from s2ag.core import json_text
from s2ag.core.json_text import NotJson, parse


def test_what_is_json_is_read(tmp_path):
    (tmp_path / "a.json").write_bytes('\ufeff{"é": [1, 2.5, null, "\\ud83d\\ude00"]}'.encode())
    plain = {"é": [1, 2.5, None, "\U0001f600"]}
    assert json_text.read(tmp_path / "a.json") == parse('{"é": [1, 2.5, null, "\U0001f600"]}') == plain


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "Expecting value at line 1, column 1"),
        ("[1,\n2", "at line 2"),
        (b"\xff{}", "no text in UTF-8"),
        ("[" * 65 + "]" * 65, "64 deep"),
        ('{"a":' * 900 + "1" + "}" * 900, "64 deep"),
        ("[" * 100_000, "64 deep"),
        ('{"a":' * 1_000_000, "64 deep"),
    ],
)
def test_what_is_not_is_one_sentence(text, why):
    with pytest.raises(NotJson, match=why):
        parse(text)


def test_size_and_depth_have_bounds(tmp_path):
    assert parse("[" * 64 + "]" * 64)
    (tmp_path / "a.json").write_text('"' + "x" * 3_000_000 + '"')
    with pytest.raises(NotJson, match="larger than 2 MB"):
        json_text.read(tmp_path / "a.json", 2_000_000)


def test_numbers_fit_and_texts_can_be_written():
    exact, long, longest = parse(f"[{10**17}, {10**30}, {'9' * 5000}]")
    assert exact == 10**17 and long == pytest.approx(1e30) and longest == float("inf")
    assert parse(r'"\\ud800"') == r"\ud800"
    with pytest.raises(NotJson, match="half a letter"):
        parse(r'{"a": "b\udfff"}')


def test_no_key_twice_where_it_matters():
    assert parse('{"a": 1, "a": 2}') == {"a": 2}
    with pytest.raises(NotJson, match='it names "a" twice'):
        parse('{"a": 1, "a": 2}', once=True)
