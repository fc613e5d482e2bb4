"""Manifests: what they may say, and that everything wrong is named with its line before anything starts."""

import json

import pytest
from s2ag.core.batch import checks, clip, manifest
from s2ag.core.errors import UsageError


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
    with pytest.raises(manifest.ManifestUnusable, match="column audio"):
        written("sound\nhello.flac\n")
    with pytest.raises(manifest.ManifestUnusable, match="no clips"):
        written("audio\n")
    with pytest.raises(manifest.ManifestUnusable, match="cannot be read"):
        manifest.read(tmp_path / "gone.csv")
    with pytest.raises(manifest.ManifestUnusable, match="not a manifest"):
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


@pytest.mark.parametrize("name", ["hello.txt", "hello.srt", "hello.vtt", "hello.TextGrid"])
def test_a_transcript_beside_the_recording_is_found(written, tmp_path, name):
    (tmp_path / name).write_text("hello")
    clips, problems = written("audio,text,no_transcript\nhello.flac,,\nhello.flac,something else,\nhello.flac,,yes\n")
    assert [one.transcript for one in clips] == [str(tmp_path / name), None, None] and not problems
    manifest.write(clips, tmp_path / "plan.jsonl")
    (tmp_path / "hello.txt").write_text("written later")
    again, _ = manifest.read(tmp_path / "plan.jsonl")
    assert [one.transcript for one in again] == [one.transcript for one in clips]  # a plan leaves nothing open


def test_recordings_without_words_are_recognised_if_asked(written, tmp_path):
    (tmp_path / "said.txt").write_text("hello")
    (tmp_path / "said.flac").write_bytes((tmp_path / "hello.flac").read_bytes())
    rows = (
        "audio,text,no_transcript,recognise\nhello.flac,,,\nhello.flac,hi,,\nhello.flac,,yes,\nsaid.flac,,,\nsaid.flac,,,yes\n"
    )
    clips, _ = written(rows, recognise=True)
    assert [one.recognise for one in clips] == [True, False, False, False, True]
    assert [one.no_transcript for one in written(rows)[0]] == [True, False, True, False, False]
    clips, problems = written("audio,text,recognise\nhello.flac,hi,yes\n")
    assert not clips and "one of" in problems[0].sentence


def test_all_that_synth_and_animate_can_do_has_a_column():
    """Options of the single commands by the name of their column; what a batch says once or in its own way is listed."""
    from s2ag.core.cli.parser import parser

    parsed = parser().parse_args(["animate", "a.wav", "-o", "a.bvh"])
    own_way = {"chosen": "cell", "verbose": None, "run": None, "cache": None, "sound": None}
    columns = {own_way.get(name, name) for name in vars(parsed)} - {None}
    assert columns <= set(manifest.COLUMNS)
    options = vars(parser().parse_args(["batch", "run", "a.csv", "-o", "out"]))
    assert {"cache", "checkpoint", "vectors", "aligner_model", "recogniser_model", "language", "recognise"} <= set(options)


def test_a_character_sits_at_a_table(written):
    clips, problems = written("audio,seated\nhello.flac,0.74\nhello.flac,\nhello.flac,perhaps\n")
    assert [clip.seated for clip in clips] == ["0.74", "auto"] and "table's height" in problems[0].sentence


def test_files_beside_the_recording_are_checked(written, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "map.json").write_text('{"torso": ["Spine"], "tail": []}')
    (tmp_path / "words.json").write_text('{"neither": "words"}')
    head = "audio,map,aligner_model,vectors,checkpoint,transcript,start_frame,outputs\n"
    rows = ["map.json,,,,,,mp4", ",empty,,,,,", ",,words.json,,,,", ",,,words.json,,,", ",,,,words.json,,", ",,,,,-1,"]
    rows += ["gone.json,,,,,,fbx"]
    clips, problems = written(head + "".join(f"hello.flac,{row}\n" for row in rows) + "hello.flac,,,,,,1001,\n")
    found = sentences(checks.check(clips))
    assert not problems and set(found) == set(range(2, 9))
    assert "tail" in found[2] and "dictionary" in found[3] and "vectors" in found[4] and "words.json" in found[5]
    assert "words.json" in found[6] and "-1" in found[7] and "does not exist" in found[8]


def test_timed_words_are_a_transcript(written, tmp_path):
    (tmp_path / "words.json").write_text('[["hello", 0.3, 0.6]]')
    clips, problems = written("audio,transcript\nhello.flac,words.json\n")
    assert not problems and not checks.check(clips)


def test_a_cell_of_a_sample_is_a_row(written, tmp_path, random_checkpoint, plain_checkpoint):
    from s2ag.core.model import checkpoint_metadata
    from s2ag.core.sampling import sheet as sheets

    cells = [sheets.Cell(0, take, "calm one", 3, take, [[float(take)] * 16]) for take in (0, 1)]
    digest, settings = checkpoint_metadata.describe(random_checkpoint)["hash"], {"text": "hello", "mirror": True}
    sheet = sheets.Sheet(str(tmp_path / "hello.flac"), digest, cells, settings)
    sheet.save(tmp_path / "sheet.json")
    clips, problems = written("cell,audio,text\nsheet.json:2,,\nsheet.json:1,,other words\n", style="lively one")
    assert not problems and not checks.check(clips)
    assert (clips[0].style, clips[0].seed, clips[0].take, clips[0].text) == ("calm one", 3, 1, "hello")
    assert clips[0].latent == cells[1].latent
    assert clips[0].audio == sheet.audio and clips[0].mirror and clips[1].text == "other words"
    manifest.write(clips, tmp_path / "plan.jsonl")
    again, _ = manifest.read(tmp_path / "plan.jsonl", {"style": "lively one"})
    assert [{**one.plain(), "line": 0} for one in again] == [{**one.plain(), "line": 0} for one in clips]
    _, problems = written("cell,seed\nsheet.json:2,4\nsheet.json:3,\nhello.flac:1,\n")
    assert len(problems) == 3 and "own seed" in problems[0].sentence
    assert "cell 3" in problems[1].sentence and "not a sample" in problems[2].sentence
    _, problems = written("cell\nsheet.json:2\n", checkpoint=str(plain_checkpoint))
    assert "another checkpoint" in problems[0].sentence


WRONG = [
    {"audio": 5}, {"seed": "x"}, {"seed": 1.5}, {"seed": True}, {"seed": 1e999}, {"takes": []}, {"style": {"a": 1}},
    {"affect": [1]}, {"mirror": 3}, {"outputs": [5]}, {"resolution": [1e999, 48]}, {"resolution": [64.7, 48]},
    {"audio": "a\0.wav"}, {"text": "\ud800"}, {"hand": "up"}, {"name": 7}, {"name": "con"}, {"name": "é" * 80},
    {"latent": [["x"]]}, {"latent": [[1e999]]}, {"map": 3},
    {"start_frame": 1.5}, {"recognise": "perhaps"}, {"cell": "hello.flac:1"},
]  # fmt: skip


@pytest.mark.parametrize("row", WRONG, ids=lambda row: str(row)[:30])
def test_values_of_wrong_types_are_one_problem_each(written, row):
    clips, problems = written(json.dumps({"audio": "hello.flac", **row}) + "\n", "clips.jsonl")
    assert not clips and len(problems) == 1 and (next(iter(row)) in problems[0].sentence or "cell" in row)


def test_the_manners_of_spreadsheets(written, tmp_path):
    folder = tmp_path / "ünï cödé"
    folder.mkdir()
    (folder / "klip einß.flac").write_bytes((tmp_path / "hello.flac").read_bytes())
    text = "\ufeff# a remark, with commas, first\r\nAudio ;TEXT;outputs;\r\n\r\n;;;\r\nhello.flac;hi;bvh;\r\n"
    text += f'{folder}/klip einß.flac;;"bvh, npz";\r\n'
    clips, problems = written(text)
    assert not problems and not checks.check(clips)
    assert [one.name for one in clips] == ["0001_hello", "0002_klip_einß"] and clips[1].outputs == ("bvh", "npz")
    assert [one.line for one in clips] == [5, 6]


@pytest.mark.parametrize(
    "rows", ["a,2,,\na,1,,", "s-1,1,,\nx,2,s,", "x,1,s,\ns,1,,", "x,1,Talk,\ny,1,talk,", "x,1,s,\nx,1,s,", "é,1,,\ne\u0301,1,,"]
)
def test_names_whose_files_or_records_would_meet_are_refused(written, rows):
    lines = [f"hello.flac,{row}" for row in rows.split("\n")]
    clips, _ = written("audio,name,takes,scene,outputs\n" + "\n".join(lines) + "\n")
    assert [problem.line for problem in checks.check(clips)] == [3]


def test_a_clip_may_be_called_like_its_own_scene(written):
    clips, _ = written("audio,name,takes,scene\nhello.flac,talk,2,talk\nhello.flac,other,2,talk\n")
    assert not checks.check(clips)


def test_a_plan_written_is_the_same_when_read(written, tmp_path):
    clips, _ = written("audio,takes,affect,scene\nhello.flac,2,arousal=1,s\nhello.flac,2,,s\n")
    manifest.write(clips, tmp_path / "plan.jsonl")
    again, problems = manifest.read(tmp_path / "plan.jsonl")
    assert not problems
    assert [{**one.plain(), "line": 0} for one in again] == [{**one.plain(), "line": 0} for one in clips]


@pytest.mark.parametrize("name", ["plan.jsonl", "clips.csv"])
def test_breaks_that_end_no_line_of_json_stay_in_texts(written, tmp_path, name):
    """Word processors leave U+2028, terminals U+0085; only a line feed ends a line of JSON."""
    text = "one\u2028two\u2029three\x85four\x0bfive\x1csix"
    row = {"audio": "hello.flac", "text": text}
    content = f'audio,text\nhello.flac,"{text}"\n' if name.endswith("csv") else json.dumps(row, ensure_ascii=False)
    clips, problems = written(content, name)
    assert not problems and clips[0].text == text
    manifest.write(clips, tmp_path / "again.jsonl")
    again, problems = manifest.read(tmp_path / "again.jsonl")
    assert not problems and again[0].text == text


def test_slices_cover_everything_once_and_keep_scenes_together():
    clips = [clip.Clip(line, f"c{line}", "a", scene="s" if line in (3, 7) else "") for line in range(1, 12)]
    every = clip.units(clips)
    assert len(every) == 10 and [one.name for one in every[2].clips] == ["c3", "c7"]
    for count in (1, 3, 10, 13):
        parts = [clip.select_units(every, f"{k}/{count}") for k in range(1, count + 1)]
        assert [unit.number for part in parts for unit in part] == list(range(1, 11))
    assert [unit.number for unit in clip.select_units(every, None, "2-3,9")] == [2, 3, 9]
    for wrong in ("0/3", "4/3", "x"):
        with pytest.raises(UsageError):
            clip.select_units(every, wrong)
    with pytest.raises(UsageError):
        clip.select_units(every, None, "1..3")


def test_names_of_takes_sort():
    assert [clip.take_name("a", take, 10) for take in (0, 9)] == ["a-01", "a-10"]
    assert clip.take_name("a", 0, 1) == "a"


@pytest.mark.parametrize("name", ["CON", "aux.wav", "com1.flac", "LPT².wav", "nul.tar.gz"])
def test_names_of_devices_are_no_names_of_files(name):
    stem, dot, rest = name.partition(".")  # on Windows all that stands before the first dot makes a device of it
    assert clip.safe_name(name) == f"{stem}_{dot}{rest}" and clip.safe_name(f"my{name}") == f"my{name}"
