"""What comes in takes time in proportion to its size: no text that is eight times as long takes more than three times that."""

import time

import doors
import pytest
from s2ag.core.errors import S2agError

pytest.importorskip("praatio", reason="the engine is not installed")

CUE = "00:00:01.000 --> 00:00:02.000\na<00:00:01.500>b\n\n"
TIER = '"IntervalTier"\n"words"\n0\n1\n1\n0\n1\n"a"\n'
GRID = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\n'
ASS = "[Script Info]\n[Events]\nFormat: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text\n"
SAID = "Dialogue: 0,0:00:01.00,0:00:02.00,a,b,0,0,0,,"
LONG = [
    *(("transcript", ".ass", f"{ASS}{SAID}", part) for part in ("{\\", "{", "{a", "\\N", "<")),
    *(
        ("transcript", ".txt", "", part)
        for part in ("$", "$1 ", "million ", "(", "*a", "{a} b ", "[pause] ", "A: ", "ANNA: a\n")
    ),
    *(("transcript", ".txt", "a ", part) for part in ("a--", "a-", "1,", "..", "{", "<", "[", " ", ">> ", "- ", "A b. ")),
    *(("transcript", ".vtt", "WEBVTT\n\n", part) for part in (CUE, "NOTE ", "NOTE\n\n", "<", "<00:00:01.000>", "&amp;", "\n")),
    *(("transcript", ".srt", "1\n00:00:01,000 --> 00:00:02,000\n", part) for part in ("<", "{\\", "a\n", "00:", "\n ")),
    *(("transcript", ".ass", ASS, part) for part in (SAID + "c\n", "{\\", "Format: a,b\n")),
    *(("transcript", ".TextGrid", GRID, part) for part in ("xmin = 1\n", 'text = "', "intervals [1]:\n", "item [1]:\n")),
    ("transcript", ".TextGrid", GRID + "0\n1\n<exists>\n9\n", TIER),
    *(("transcript", ".json", "[", part) for part in ('["a",1,2],', "[", '{"word":"a","start":1,"end":2},')),
    ("transcript", ".ctm", "", "a 1 0.1 0.1 a\n"),
    ("transcript", ".txt", "", "0.1\t0.2\ta\n"),
    *(("turns", ".txt", "ANNA: a\n", part) for part in ("ANNA: a\nBERT: b\n", "A" * 30 + ": a\n", "B:")),
    *(
        ("data-transcript", ".TextGrid", "item [1]:\n", part)
        for part in ("xmin = 1 xmax = 2 ", 'text = "', "xmin = ", "item [")
    ),
    *(("performance", ".bvh", "HIERARCHY\nROOT a {\n", part) for part in ("JOINT b {\n", "} ", "CHANNELS 0 ", "OFFSET 0 0 0 ")),
    *(("manifest", ".csv", "audio,name\n", part) for part in ("a.wav,b\n", '"', ",", '"a\n')),
    *(("manifest", ".jsonl", "", part) for part in ('{"audio":"a.wav"}\n', "{")),
    *(("edits", ".json", '{"format":1,"edits":[', part) for part in ('{"do":"delete","at":1},', "[")),
    *(("mouth-cues", ".tsv", "", part) for part in ("0.1\tA\n", "0.1\tX\n")),
    *(("letters", ".json", "{", part) for part in ('"a":"A",', "[")),
    *(("acoustic", ".own.dict", "", part) for part in ("hello A B\n", "hello(2) A", " ")),
]
SMALL, TIMES, MOST = 4_000, 8, 24
"""Bytes, and what makes them large: linear work takes 8 times as long then, work that grows with the square 64 times."""
_SHORT = 0.02
"""Seconds of CPU below which nothing is measured."""


def spent(door, path) -> float:
    """Seconds of CPU, the least of three: what else the machine does adds to them."""
    least = float("inf")
    for _ in range(3):
        began = time.process_time()
        try:
            door.use(path)
        except S2agError as error:
            assert len(error.message) < 2000
        least = min(least, time.process_time() - began)
        if least < _SHORT:
            break
    return least


@pytest.mark.parametrize("case", range(len(LONG)))
def test_work_grows_no_faster_than_what_comes_in(case, tmp_path):
    name, suffix, head, part = LONG[case]
    door, path = doors.DOORS[name], tmp_path / f"input{suffix}"
    times = []
    for size in (SMALL, TIMES * SMALL):
        path.write_text(head + part * (size // len(part)), "utf-8")
        times.append(spent(door, path))
    assert times[1] <= MOST * max(times[0], _SHORT / TIMES), f"{times[1]:.2f} s after {times[0]:.3f} s: {part!r}"
