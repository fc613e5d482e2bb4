"""Recordings beside words that are not theirs: each pair ends in a performance or in two sentences, in bounded time and memory.

``S2AG_FUZZ=20000 pytest tests/fuzz/test_pairs.py`` draws as many pairs as that; ``S2AG_FUZZ_FIRST`` is the first one's number.
"""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pairs
import pytest
from s2ag.core.synthesis.session import Session

COUNT, FIRST = int(os.environ.get("S2AG_FUZZ", "800")) // 40, int(os.environ.get("S2AG_FUZZ_FIRST", "0"))
NO_SPEECH = [(sound, count, text, 2) for sound in ("silence", "noise", "hum", "speech") for count in (1, 800, 3200)
             for text in ("one", "sentence")]  # fmt: skip


@pytest.fixture(scope="module")
def session():
    return Session(cache="off")


@pytest.mark.parametrize("pair", NO_SPEECH, ids=str)
def test_words_beside_sound_without_speech_are_performed(session, tmp_path, pair):
    assert not pairs.attempt(session, tmp_path, pair)


@pytest.mark.timeout(0 if COUNT > 500 else 300)
def test_every_pair_ends_in_a_performance_or_in_two_sentences(session, tmp_path):
    fallen = {number: pairs.attempt(session, tmp_path, pairs.drawn(number)) for number in range(FIRST, FIRST + COUNT)}
    fallen = {(number, pairs.drawn(number)): wrong for number, wrong in fallen.items() if wrong}
    assert not fallen, f"{len(fallen)} of {COUNT} fell, the first: {next(iter(fallen.items()))}"


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("seconds", "words"), [(0.1, "yes "), (5, "I do not know it. "), (1, "a")])
def test_a_megabyte_of_words_takes_bounded_time_and_memory(tmp_path, seconds, words):
    """A minute of CPU and one gigabyte at most, which numpy, the weights and a megabyte of words as objects stay far below."""
    code = f"import pairs, pathlib; pairs.perform_long({seconds}, {words!r}, pathlib.Path({str(tmp_path)!r}))"
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (60, 60)), capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) < 1_000_000, f"{done.stdout} kB"
