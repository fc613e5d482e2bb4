"""Data-set readers on small files in the true layouts, axes and handedness, and one sentence for each malformed file."""

import json

import moving
import numpy as np
import pytest

pytest.importorskip("torch")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.datasets import readers, transcripts, writer  # noqa: E402
from s2ag.core.learning.datasets.growing_array import GrowingArray  # noqa: E402
from s2ag.core.learning.datasets.recording import Recording  # noqa: E402
from s2ag.core.learning.train.dataset import Corpus  # noqa: E402
from s2ag.core.learning.train.storage import load_arrays  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402


def trinity(folder):
    for part, names in (("Training_data", ("Recording_001", "Recording_002")), ("Test_data", ("TestSeq001",))):
        for kind in ("Motion", "Audio", "Transcripts"):
            (folder / part / kind).mkdir(parents=True)
        for name in names:
            moving.bvh(folder / part / "Motion" / f"{name}.bvh")
            moving.sound(folder / part / "Audio" / f"{name}.wav", rate=44100)
            moving.google(folder / part / "Transcripts" / f"{name}.json")
    return folder


def test_trinity_end_to_end(tmp_path, capsys):
    assert main(["data", "trinity", str(trinity(tmp_path / "genea")), "-o", str(tmp_path / "out")]) == 0
    assert "3 recordings (1 train, 1 validation, 1 test)" in capsys.readouterr().out
    arrays, meta = load_arrays(tmp_path / "out")
    corpus = Corpus.load(tmp_path / "out")
    assert meta["words"] == ["deep", "water"] and corpus.speakers[0]["name"] == "trinity"
    moving.check(arrays["directions"][arrays["starts"][0] : arrays["starts"][1]].astype(np.float32))
    word = arrays["word_index"][: arrays["frame_starts"][1]]
    assert (word[6:12] == 0).all() and (word[15:22] == 1).all() and word[2] == -1
    assert arrays["wave"].dtype == np.int16 and np.diff(arrays["wave_starts"]).min() == 80000
    assert np.abs(arrays["wave"].astype(float)).max() > 3000


def test_zeroeggs_and_beat2(tmp_path):
    eggs = tmp_path / "eggs" / "animation"
    eggs.mkdir(parents=True)
    (tmp_path / "eggs" / "audio").mkdir()
    moving.bvh(eggs / "010_Happy_1_x_1_0.bvh")
    moving.sound(tmp_path / "eggs" / "audio" / "010_Happy_1_x_1_0.wav")
    found = readers.zeroeggs(tmp_path / "eggs")
    assert [(one.speaker, one.words) for one in found] == [("happy", None)]
    beat = tmp_path / "beat"
    for kind in ("smplxflame_30", "wave16k", "textgrid"):
        (beat / kind).mkdir(parents=True)
    for name in ("2_scott_0_1_1", "2_scott_0_2_2"):
        moving.smplx(beat / "smplxflame_30" / f"{name}.npz")
        moving.sound(beat / "wave16k" / f"{name}.wav")
        moving.textgrid(beat / "textgrid" / f"{name}.TextGrid")
    (beat / "train_test_split.csv").write_text("id,type\n2_scott_0_1_1,val\n2_scott_0_2_2,test\n")
    found = list(readers.recordings(readers.beat2(beat)))
    assert [(one.speaker, one.split) for one in found] == [("scott", "validation"), ("scott", "test")]
    assert found[0].words == [('say "hi"', 1.2, 1.7), ("friend", 2.0, 2.5)]
    moving.check(found[0].directions)


def test_plain_folders(tmp_path):
    for name in ("anna/one", "ben/two"):
        (tmp_path / name).parent.mkdir()
        moving.bvh(tmp_path / f"{name}.bvh")
        moving.sound(tmp_path / f"{name}.wav")
        (tmp_path / f"{name}.json").write_text(json.dumps([["hello", 0.2, 0.6]]))
    moving.bvh(tmp_path / "silent.bvh")
    found = readers.plain(tmp_path)
    assert [(one.name, one.speaker) for one in found] == [("anna/one", "anna"), ("ben/two", "ben")]
    assert {one.speaker for one in readers.plain(tmp_path, "me")} == {"me"}
    assert next(readers.recordings(found)).words == [("hello", 0.2, 0.6)]


def test_what_is_left_out_is_told(tmp_path, capsys):
    eggs, beat, mine = (tmp_path / name for name in ("eggs", "beat", "mine"))
    for folder in (eggs, beat / "smplxflame_30", beat / "wave16k", mine):
        folder.mkdir(parents=True)
    for name in ("010_Happy_1_x_1_0", "011_Sad_1_x_1_0", "notes"):
        moving.bvh(eggs / f"{name}.bvh")
    moving.sound(eggs / "010_Happy_1_x_1_0.wav")
    for name in ("2_scott_0_1_1", "2_scott_0_2_2", "odd"):
        moving.smplx(beat / "smplxflame_30" / f"{name}.npz")
    moving.sound(beat / "wave16k" / "2_scott_0_1_1.wav")
    for name in "abcde":
        moving.bvh(mine / f"{name}.bvh")
    moving.sound(mine / "a.wav")
    for kind, folder, told in (
        ("zeroeggs", eggs, ("no style in their names are left out (1): notes.bvh", "left out (1): 011_Sad_1_x_1_0.bvh")),
        ("beat2", beat, ("no speaker in their names are left out (1): odd.npz", "left out (1): 2_scott_0_2_2.npz")),
        ("plain", mine, ("left out (4): b.bvh, c.bvh, d.bvh and 1 more.",)),
    ):
        assert main(["data", kind, str(folder), "-o", str(tmp_path / f"{kind}-out")]) == 0
        said = capsys.readouterr().err
        assert all(one in said for one in told) and said.count("s2ag: note: ") == len(told)


def test_tenths_do_not_depend_on_the_place():
    parts = [readers.split_of(f"take {number}") for number in range(2000)]
    assert [round(parts.count(kind) / 2000, 1) for kind in ("train", "validation", "test")] == [0.8, 0.1, 0.1]


def test_what_several_people_perform_is_in_one_part(tmp_path):
    for who in ("anna", "bert"):
        (tmp_path / who).mkdir()
        for number in range(12):
            for suffix in (".bvh", ".wav"):
                (tmp_path / who / f"talk {number}{suffix}").touch()
    parts: dict[str, set] = {}
    for one in readers.plain(tmp_path):
        parts.setdefault(one.motion.stem, set()).add(one.split)
    assert len(parts) == 12 and all(len(found) == 1 for found in parts.values()) and len(set.union(*parts.values())) > 1


def test_malformed_transcripts_are_one_sentence(tmp_path):
    for name, content in (
        ("a.json", "{"),
        ("b.json", '[["x"]]'),
        ("c.TextGrid", "nothing"),
        ("d.json", '[{"alternatives": 3}]'),
    ):
        (tmp_path / name).write_text(content)
        with pytest.raises(CorpusUnreadable, match="transcript"):
            transcripts.read(tmp_path / name, np.zeros(16000, np.float32))


def test_missing_folders_and_options_are_one_sentence(tmp_path, capsys):
    for command, sentence in (
        (["plain", str(tmp_path / "no")], "no folder"),
        (["plain", str(tmp_path)], "holds no performance"),
        (["trinity", str(tmp_path)], "holds no performance"),
        (["beat2", str(tmp_path)], "holds no performance"),
        (["ted", str(tmp_path)], "no lmdb_train"),
        (["magic", str(tmp_path)], "no kind of data set"),
        (["directed", str(tmp_path)], "lacks its sound"),
    ):
        assert main(["data", *command, "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert sentence in said and said.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_a_missing_sound_of_trinity_is_named(tmp_path):
    folder = trinity(tmp_path)
    (folder / "Test_data" / "Audio" / "TestSeq001.wav").unlink()
    with pytest.raises(CorpusUnreadable, match="TestSeq001.wav is missing"):
        readers.trinity(folder)


def test_short_recordings_are_counted_and_nothing_is_left_of_a_failure(tmp_path):
    directions = np.broadcast_to(skeleton.MEAN_UNIT, (60, 9, 3))
    long, short = (Recording("r", np.full(n, 0.1), [("a", 0.1, 0.5)], directions, "me") for n in (64000, 1600))
    facts = writer.write([long, short], tmp_path / "out", "test")
    assert facts["recordings"] == 1 and facts["too short"] == 1

    def broken():
        yield long
        raise CorpusUnreadable("stop.")

    for source in ([short], broken()):
        with pytest.raises(CorpusUnreadable):
            writer.write(source, tmp_path / "other", "test")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_growing_arrays_are_ordinary_files(tmp_path):
    rng = np.random.default_rng(0)
    parts = [rng.normal(size=(n, 9, 3)).astype(np.float16) for n in (5, 0, 7)]
    array = GrowingArray(tmp_path / "a.npy", np.float16, (9, 3))
    for part in parts:
        array.append(part)
    with pytest.raises(ValueError, match="do not fit"):
        array.append(np.zeros((2, 3)))
    array.close()
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy", mmap_mode="r", allow_pickle=False), np.concatenate(parts))


@pytest.mark.parametrize("content", [b"id,type\n\xf4\xff", b'id,type\n"' + b"a" * 200_000], ids=["no text", "a long cell"])
def test_a_damaged_table_of_parts_is_one_sentence(tmp_path, content):
    (tmp_path / "train_test_split.csv").write_bytes(content)
    with pytest.raises(CorpusUnreadable, match="train_test_split.csv is no readable table"):
        readers.beat2(tmp_path)
