"""Manifests: what they may say, and that everything wrong is named with its line before anything starts."""

import json

import pytest
from s2ag.core.batch import checks, clip, manifest
from s2ag.core.errors import ManifestUnusable, UsageError


@pytest.fixture
def written(tmp_path, examples, random_checkpoint):
    """A function that writes a manifest beside a copy of the shipped recording and reads it back."""
    (tmp_path / "hello.flac").write_bytes((examples / "hello.flac").read_bytes())

    def write(text, name="clips.csv", **defaults):
        (tmp_path / name).write_text(text, "utf-8")
        return manifest.read(tmp_path / name, {"checkpoint": str(random_checkpoint), **defaults})

    return write


def sentences(problems):
    return {problem.line: problem.sentence for problem in problems}


def test_csv_and_json_lines_say_the_same(written, tmp_path):
    head = "audio,style,seed,affect,hand,mirror,outputs,resolution,text"
    table, none = written(f'{head}\nhello.flac,stern,3,"arousal=0.5 valence=-1",left,yes,"bvh, mp4",640x360,Hi you\n')
    row = {
        "audio": "hello.flac", "style": "stern", "seed": 3, "affect": {"arousal": 0.5, "valence": -1}, "hand": -1,
        "mirror": True, "outputs": ["bvh", "mp4"], "resolution": [640, 360], "text": "Hi you",
    }  # fmt: skip
    lines, nothing = written(json.dumps(row) + "\n", "clips.jsonl")
    assert not none and not nothing
    assert table[0].line == 2 and lines[0].line == 1
    assert {**table[0].plain(), "line": 0} == {**lines[0].plain(), "line": 0}
    assert table[0].name == "0001_hello" and table[0].audio == str(tmp_path / "hello.flac")
    assert clip.Clip.of(json.loads(json.dumps(table[0].plain()))) == table[0]


def test_every_problem_is_named_with_its_line(written):
    clips, problems = written(
        "name,audio,style,seed,takes,resolution,fps\n"
        "a,hello.flac,calm one,1,1,,\n"
        "b,gone.wav,calm one,1,1,,\n"
        "c,hello.flac,calm wun,1,1,,\n"
        "# a remark\n"
        "d,hello.flac,calm one,x,1,,\n"
        "a,hello.flac,calm one,1,99,,\n"
        "../e,hello.flac,calm one,1,1,,\n"
        "f,hello.flac,calm one,1,1,9x9,500\n"
        "g,hello.flac,calm one,1,1,90x90,500,more\n"
        "h,hello.flac,calm one,1,1,90x90,500\n"
    )
    found = sentences(problems + checks.check(clips))
    assert set(found) == {3, 4, 6, 7, 8, 9, 10, 11}
    assert "gone.wav" in found[3] and "calm one" in found[4] and "whole number" in found[6]
    assert "file's name" in found[8] and "range" in found[9] and "cells" in found[10] and "500" in found[11]


def test_same_names_are_refused_whatever_the_case(written):
    clips, _ = written("name,audio,takes\nA,hello.flac,1\na,hello.flac,1\nb-1,hello.flac,1\nb,hello.flac,2\n")
    found = sentences(checks.check(clips))
    assert "line 2" in found[3] and "line 4" in found[5] and len(found) == 2


@pytest.mark.parametrize("text", ["audio,colour\nhello.flac,red\n", '{"audio": "hello.flac", "colour": 1}\n', "[1]\n", "{\n"])
def test_unknown_columns_and_no_json(written, text):
    clips, problems = written(text, "clips.csv" if text.startswith("audio") else "clips.jsonl")
    assert problems[0].line == 1 and (not clips or "colour" in problems[0].sentence)


def test_what_cannot_be_read_at_all(written, tmp_path):
    with pytest.raises(ManifestUnusable, match="column audio"):
        written("sound\nhello.flac\n")
    with pytest.raises(ManifestUnusable, match="no clips"):
        written("audio\n")
    with pytest.raises(ManifestUnusable, match="cannot be read"):
        manifest.read(tmp_path / "gone.csv")
    with pytest.raises(ManifestUnusable, match="not a manifest"):
        manifest.read(tmp_path / "hello.flac")


def test_rows_of_a_scene_agree_and_use_one_file(written, tmp_path):
    for name in ("one.blend", "two.blend"):
        (tmp_path / name).write_bytes(b"BLENDER")
    head = "name,audio,scene,character,armature,fps,outputs\n"
    clips, _ = written(
        f"{head}a,hello.flac,talk,one.blend,Ann,24,mp4\nb,hello.flac,talk,two.blend,Bob,25,mp4\nc,hello.flac,talk,one.blend,Ann,24,"
    )
    found = [problem.sentence for problem in checks.check(clips)]
    assert any("fps differs from line 2" in sentence for sentence in found)
    assert any("several .blend" in sentence for sentence in found)
    assert sum("another armature" in sentence for sentence in found) == 2


def test_defaults_fill_what_rows_leave_empty(written):
    clips, _ = written("audio,outputs\nhello.flac,\nhello.flac,npz\n", outputs=("mp4",), preset="hd", character=None)
    assert [one.outputs for one in clips] == [("mp4",), ("npz",)]
    assert clips[0].preset == "hd" and clips[0].character == "mannequin"


def test_a_text_beside_the_recording_is_its_transcript(written, tmp_path):
    (tmp_path / "hello.txt").write_text("hello")
    clips, _ = written("audio,text\nhello.flac,\nhello.flac,something else\n")
    assert clips[0].transcript == str(tmp_path / "hello.txt") and clips[1].transcript is None


def test_a_plan_written_is_the_same_when_read(written, tmp_path):
    clips, _ = written("audio,takes,affect,scene\nhello.flac,2,arousal=1,s\nhello.flac,2,,s\n")
    manifest.write(clips, tmp_path / "plan.jsonl")
    again, problems = manifest.read(tmp_path / "plan.jsonl")
    assert not problems
    assert [{**one.plain(), "line": 0} for one in again] == [{**one.plain(), "line": 0} for one in clips]


def test_slices_cover_everything_once_and_keep_scenes_together():
    clips = [clip.Clip(line, f"c{line}", "a", scene="s" if line in (3, 7) else "") for line in range(1, 12)]
    every = clip.units(clips)
    assert len(every) == 10 and [one.name for one in every[2].clips] == ["c3", "c7"]
    for count in (1, 3, 10, 13):
        parts = [clip.sliced(every, f"{k}/{count}") for k in range(1, count + 1)]
        assert [unit.number for part in parts for unit in part] == list(range(1, 11))
    assert [unit.number for unit in clip.sliced(every, None, "2-3,9")] == [2, 3, 9]
    for wrong in ("0/3", "4/3", "x"):
        with pytest.raises(UsageError):
            clip.sliced(every, wrong)
    with pytest.raises(UsageError):
        clip.sliced(every, None, "1..3")


def test_names_of_takes_sort():
    assert [clip.take_name("a", take, 10) for take in (0, 9)] == ["a-01", "a-10"]
    assert clip.take_name("a", 0, 1) == "a"
