"""Data-set readers on small files in the true layouts, axes and handedness, and one sentence for each malformed file."""

import json

import moving
import numpy as np
import pytest

pytest.importorskip("torch")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.datasets import bvh, readers, smplx, ten, transcripts, writer  # noqa: E402
from s2ag.core.learning.datasets.recording import Recording  # noqa: E402
from s2ag.core.learning.datasets.stream import GrowingArray  # noqa: E402
from s2ag.core.learning.train.dataset import Corpus  # noqa: E402
from s2ag.core.learning.train.storage import load_arrays  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402
from s2ag.core.motion.motion import Motion  # noqa: E402
from s2ag.rigs.bvh import save as save_bvh  # noqa: E402

DOWN, FORWARD = [0, 1, 0], [0, 0, 1]
LEFT_FOREARM, RIGHT_FOREARM = 5, 8


def check_the_performance(directions):
    """Arms hang, the left forearm comes forwards; the head is upright as TED's mean."""
    np.testing.assert_allclose(directions[:, [4, 7, RIGHT_FOREARM]], np.broadcast_to(DOWN, (len(directions), 3, 3)), atol=0.08)
    np.testing.assert_allclose(directions[0, LEFT_FOREARM], DOWN, atol=0.08)
    np.testing.assert_allclose(directions[-1, LEFT_FOREARM], FORWARD, atol=0.08)
    assert (directions[:, 3, 0] < -0.5).all() and (directions[:, 6, 0] > 0.5).all()  # the left lies at -x
    upright = skeleton.MEAN_UNIT[[0, 1, 2]]
    assert (np.degrees(np.arccos(np.clip((directions[0, :3] * upright).sum(-1), -1, 1))) < 12).all()


@pytest.mark.parametrize("yaw", [0.0, 140.0])
@pytest.mark.parametrize("z_up", [False, True])
def test_bvh_in_the_canonical_frame(tmp_path, yaw, z_up):
    moving.bvh(tmp_path / "a.bvh", hips_yaw=0.0 if z_up else yaw, z_up=z_up)
    if z_up:  # forearm's rotation is about the file's own z, which is up there
        posed, fps = bvh.read(tmp_path / "a.bvh")
        made = ten.directions(posed)
        assert fps == pytest.approx(60, abs=0.01)
        assert (made[:, 0, 1] < -0.9).all() and (made[:, 3, 0] < -0.5).all()
        return
    posed, fps = bvh.read(tmp_path / "a.bvh")
    check_the_performance(ten.resample(ten.directions(posed), fps))
    assert len(ten.resample(ten.directions(posed), fps)) == 75


def test_our_own_bvh_comes_back(tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(60)[:, None, None] / 15
    directions = skeleton.normalize(skeleton.MEAN_UNIT + 0.25 * np.sin(2 * time + rng.uniform(0, 6, (1, 9, 3))))
    directions[:, :4], directions[:, 6] = skeleton.MEAN_UNIT[:4], skeleton.MEAN_UNIT[6]
    save_bvh(Motion(directions.astype(np.float32)), tmp_path / "own.bvh")
    posed, fps = bvh.read(tmp_path / "own.bvh")
    found = ten.directions(posed)
    assert fps == pytest.approx(15)
    arms = [4, 5, 7, 8]
    np.testing.assert_allclose(found[:, arms], directions[:, arms], atol=0.02)


def test_the_papers_joints_put_the_right_arm_first(tmp_path):
    moving.bvh(tmp_path / "a.bvh")
    directions = ten.directions(bvh.read(tmp_path / "a.bvh")[0], paper=True)
    np.testing.assert_allclose(directions[-1, RIGHT_FOREARM], FORWARD, atol=0.08)
    np.testing.assert_allclose(directions[-1, LEFT_FOREARM], DOWN, atol=0.08)
    assert directions[0, 3, 0] > 0.5


def test_smplx_in_the_canonical_frame(tmp_path):
    moving.smplx(tmp_path / "a.npz")
    posed, fps = smplx.read(tmp_path / "a.npz")
    assert fps == 30
    check_the_performance(ten.resample(ten.directions(posed), fps))


def test_a_users_body_replaces_the_average_one(tmp_path):
    joints = np.zeros((22, 3))
    for row, parent in enumerate(smplx.PARENTS):
        joints[row] = smplx.OFFSETS[row] * 2 + (joints[parent] if parent >= 0 else 0)
    np.savez(tmp_path / "model.npz", v_template=joints, J_regressor=np.eye(22))
    np.testing.assert_allclose(smplx.model_offsets(tmp_path / "model.npz"), 2 * smplx.OFFSETS, atol=1e-12)
    with pytest.raises(CorpusUnreadable, match="no SMPL-X model"):
        smplx.model_offsets(tmp_path / "absent.npz")


def test_turns_are_proper_rotations(tmp_path):
    moving.bvh(tmp_path / "a.bvh", hips_yaw=73)
    turn = ten.frontal(bvh.read(tmp_path / "a.bvh")[0])
    np.testing.assert_allclose(np.linalg.det(turn), 1)


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
    check_the_performance(arrays["directions"][arrays["starts"][0] : arrays["starts"][1]].astype(np.float32))
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
    check_the_performance(found[0].directions)


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
    parts = [readers.tenth(f"take {number}") for number in range(2000)]
    assert [round(parts.count(kind) / 2000, 1) for kind in ("train", "validation", "test")] == [0.8, 0.1, 0.1]


def test_malformed_files_are_one_sentence(tmp_path):
    moving.bvh(tmp_path / "good.bvh", frames=3)
    text = (tmp_path / "good.bvh").read_text()
    broken = {
        "empty": "",
        "cut": text[: len(text) // 3], "short": text.rsplit("\n", 3)[0], "letters": text[:-20] + " x y z\n",
        "channel": text.replace("Xrotation", "Xturn"), "frames": text.replace("Frames: 3", "Frames: 0"),
        "foreign": "MOTION HIERARCHY {",
        "still": "HIERARCHY\nROOT Hips { OFFSET 0 0 0 CHANNELS 0 }\nMOTION\nFrames: 9999999 Frame Time: 0.004\n",
    }  # fmt: skip
    for name, content in broken.items():
        (tmp_path / f"{name}.bvh").write_text(content)
        with pytest.raises(CorpusUnreadable, match="is no BVH file"):
            bvh.read(tmp_path / f"{name}.bvh")
    with pytest.raises(CorpusUnreadable, match="cannot be read"):
        bvh.read(tmp_path / "absent.bvh")
    (tmp_path / "odd.bvh").write_text(text.replace("LeftForeArm", "Tentacle"))
    with pytest.raises(CorpusUnreadable, match="no joint for left elbow"):
        ten.directions(bvh.read(tmp_path / "odd.bvh")[0])
    np.savez(tmp_path / "few.npz", poses=np.zeros((5, 9)))
    (tmp_path / "noise.npz").write_bytes(b"zip")
    for name, sentence in (("few", "shape"), ("noise", "no SMPL-X motion")):
        with pytest.raises(CorpusUnreadable, match=sentence):
            smplx.read(tmp_path / f"{name}.npz")
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
