"""Damaged transcripts of every form: whatever they hold, they are read or refused in one sentence.

``S2AG_FUZZ=25000 pytest tests/core/words/test_readers_fuzz.py`` tries more files than the few hundred of every run.
"""

import os
import tempfile
import time
from functools import cache
from pathlib import Path

import pytest
from s2ag.core.errors import TranscriptUnreadable
from s2ag.core.words import hints, readers, transcript
from transcripts import FORMS

hypothesis = pytest.importorskip("hypothesis")
from hypothesis import strategies as st  # noqa: E402

COUNT = int(os.environ.get("S2AG_FUZZ", "400"))
SLOWEST = 5.0
GERMAN = {"acoustic": None, "dictionary": None, "letters": {}, "voice": "de"}
JUNK = [
    *('"', "\\", "[", "]", "{", "}", ",", ":", "\n", "\n\n", "\t", "-->", "<00:00:01.000>", "<v ", "NaN", "1e999", "-1"),
    *("null", "true", "9" * 400, "\0", "\ud800", "\ufeff", "*", "{none}", "[pause]", "{point left}", "SPEAKER:"),
    *("$20 million", "intervals [2]:"),
    *('""', "99:99:99,999", "é", "\U0001f600", "\ue0007", "\ue001", "%", "1990s", "3.5 %", ";;", "<exists>", '"IntervalTier"'),
    "[" * 2000,
]  # fmt: skip
MUTATION = st.tuples(
    st.sampled_from(["cut", "drop", "double", "junk", "digit", "character", "swap"]),
    st.floats(0, 1),
    st.floats(0, 1),
    st.one_of(st.sampled_from(JUNK), st.text(max_size=8)),
)


@cache
def originals():
    """The bytes of a file of every form."""
    contents = []
    with tempfile.TemporaryDirectory() as folder:
        for number, (_, name, write, _, _) in enumerate(FORMS):
            path = Path(folder) / f"{number}-{name}"
            write(path)
            contents.append((Path(name).suffix, path.read_bytes()))
    return contents


def mutated(text, mutation):
    kind, where, size, junk = mutation
    place = int(where * len(text))
    end = min(place + 1 + int(size**3 * 200), len(text))
    if kind == "cut":
        return text[:place]
    if kind == "drop":
        return text[:place] + text[end:]
    if kind == "double":
        return text[:end] + text[place:]
    if kind == "junk":
        return text[:place] + junk + text[place:]
    if kind == "character":
        return text[:place] + junk[:1] + text[place + 1 :]
    if kind == "swap":
        return text[end:] + text[place:end] + text[:place]
    digits = [number for number, char in enumerate(text) if char.isdigit()]
    at = digits[min(int(where * len(digits)), len(digits) - 1)] if digits else place
    return text[:at] + junk + text[at + 1 :]


@hypothesis.settings(max_examples=COUNT, deadline=None, database=None, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(
    st.integers(0, len(FORMS) - 1), st.lists(MUTATION, min_size=1, max_size=4), st.sampled_from(["own", ".json", ".txt"])
)
def test_damaged_files(form, mutations, suffix):
    own, data = originals()[form]
    text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8")
    for mutation in mutations:
        text = mutated(text, mutation)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{own if suffix == 'own' else suffix}"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        began = time.perf_counter()
        try:
            check(readers.parse(transcript.read(path), path))
        except TranscriptUnreadable as error:
            assert "\n" not in error.message and error.remedy
        assert time.perf_counter() - began < SLOWEST


def check(source):
    """What was read makes sense, and so does all that follows before the sound is needed."""
    for item in source.items:
        assert item.text.strip() or source.form == "plain text"
        assert item.start is None or 0 <= item.start <= item.end < 2e9
        assert not item.word or item.start is not None
    for model in (None, GERMAN):
        check_script(transcript._Script(source, 3.0, model))


def check_script(script):
    assert len(script.fixed) + len(script.loose) == len(script.tokens)
    assert sum(len(part.words) for part in script.stretches) == len(script.loose)
    edges = [edge for part in script.stretches for edge in (part.start, part.end)]
    assert edges == sorted(edges)
    words = [(shown, 0.1 * number, 0.1 * number + 0.1) for number, (shown, _) in enumerate(script.tokens)]
    hints.understand(script.marks, words)
