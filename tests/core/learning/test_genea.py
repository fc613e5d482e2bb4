"""GENEA 2022's and 2023's folders in their true layouts, names and tables."""

import moving
import numpy as np
import pytest

pytest.importorskip("torch")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.datasets import readers, transcripts  # noqa: E402
from s2ag.core.learning.train.storage import load_arrays  # noqa: E402
from s2ag.core.motion.readers import motion_files  # noqa: E402

DOWN, FORWARD = [0, 1, 0], [0, 0, 1]
WORDS = "0.4\t0.8\tSo,\n1.0\t2.0\tI am\n2.2\t2.4\t#\n2.5\t2.9\t\n"


def recording(place, name, kinds=("bvh", "wav", "tsv")):
    """One person's files of one recording."""
    for kind in kinds:
        (place / kind).mkdir(parents=True, exist_ok=True)
    if "bvh" in kinds:
        moving.talking(place / "bvh" / f"{name}.bvh")
    if "wav" in kinds:
        moving.sound(place / "wav" / f"{name}.wav", rate=44100)
    if "tsv" in kinds:
        (place / "tsv" / f"{name}.tsv").write_text(WORDS)


def challenge_2022(folder):
    for part, names in (("trn", ("000", "001")), ("val", ("000",)), ("tst", ("000",))):
        full = [f"{part}_2022_v1_{name}" for name in names]
        for name in full:
            recording(folder / part, name, ("wav", "tsv") if part == "tst" else ("bvh", "wav", "tsv"))
        table = "".join(f"{name},finger_incl,{number}\n" for number, name in enumerate(full, 1))
        (folder / part / f"{part}_2022_v1_metadata.csv").write_text(table)
    return folder


def challenge_2023(folder):
    head = "prefix,main-agent_id,main-agent_has_fingers,interloctr_id,interloctr_has_fingers\n"
    for part, names in (("trn", ("000", "001")), ("val", ("000",)), ("tst", ("000",))):
        for name in names:
            for person in ("main-agent", "interloctr"):
                recording(folder / part / person, f"{part}_2023_v0_{name}_{person}")
        rows = "".join(f"{part}_2023_v0_{name},0{n},fingers_excl,09,fingers_incl\n" for n, name in enumerate(names, 3))
        (folder / part / "metadata.csv").write_text(head + rows)
    return folder


def test_2022_end_to_end(tmp_path, capsys):
    assert main(["data", "genea", str(challenge_2022(tmp_path / "genea")), "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr()
    assert "3 recordings (2 train, 1 validation, 0 test)" in said.out and "2 speakers" in said.out
    assert "no motion in bvh are left out (1): tst_2022_v1_000." in said.err
    arrays, meta = load_arrays(tmp_path / "out")
    assert meta["recordings"][0]["words"] == [["so", 0.4, 0.8], ["i", 1.0, 1.5], ["am", 1.5, 2.0]]
    directions = arrays["directions"][arrays["starts"][0] : arrays["starts"][1]].astype(np.float32)
    assert len(directions) == 75
    np.testing.assert_allclose(directions[:, [4, 7, 8]], np.broadcast_to(DOWN, (75, 3, 3)), atol=0.08)
    np.testing.assert_allclose(directions[-1, 5], FORWARD, atol=0.08)
    assert (directions[:, 3, 0] < -0.5).all() and (directions[:, 6, 0] > 0.5).all()
    assert [one["name"] for one in meta["speakers"]] == ["1", "2"]


def test_2023_reads_the_main_agents(tmp_path, capsys):
    found = readers.genea(challenge_2023(tmp_path / "genea"), [].append)
    assert [(one.name, one.speaker, one.split) for one in found] == [
        ("trn_2023_v0_000_main-agent", "3", "train"),
        ("trn_2023_v0_001_main-agent", "4", "train"),
        ("val_2023_v0_000_main-agent", "3", "validation"),
        ("tst_2023_v0_000_main-agent", "3", "test"),
    ]
    assert main(["data", "genea", str(tmp_path / "genea"), "-o", str(tmp_path / "out")]) == 0
    assert "Interlocutors are left out (4): the main agents are read." in capsys.readouterr().err


def test_folders_within_folders_and_a_missing_table(tmp_path):
    recording(tmp_path / "trn" / "trn", "trn_2022_v1_000")
    told: list[str] = []
    (one,) = readers.genea(tmp_path, told.append)
    assert one.speaker == "unknown" and len(told) == 1 and "one speaker, unknown (1): trn_2022_v1_000" in told[0]


def test_silence_and_words_beyond_the_end_are_counted(tmp_path, capsys):
    for name in ("trn_2022_v1_000", "trn_2022_v1_001"):
        recording(tmp_path / "trn", name)
    moving.sound(tmp_path / "trn" / "wav" / "trn_2022_v1_001.wav", seconds=0.05)
    silence = tmp_path / "trn" / "wav" / "trn_2022_v1_002.wav"
    recording(tmp_path / "trn", "trn_2022_v1_002")
    data = bytearray(silence.read_bytes())
    data[44:] = bytes(len(data) - 44)
    silence.write_bytes(data)
    (tmp_path / "trn" / "tsv" / "trn_2022_v1_000.tsv").write_text("7.0\t7.5\tlate\n1.0\t1.0\tnever\n1.0\t1.4\tnow\n")
    (tmp_path / "trn" / "metadata.csv").write_text("".join(f"trn_2022_v1_00{n},finger_excl,07\n" for n in range(3)))
    assert main(["data", "genea", str(tmp_path), "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().err
    assert "1 recordings are shorter than 34 frames" in said and "1 recordings hold silence alone" in said
    assert "2 words lie outside their recording" in said


def test_a_motion_of_genea_is_a_motion(tmp_path):
    moving.talking(tmp_path / "a.bvh")
    motion = motion_files.load(tmp_path / "a.bvh")
    assert motion.fps == pytest.approx(30, abs=1e-3) and len(motion.directions) == 150
    np.testing.assert_allclose(motion.directions[-1, 5], FORWARD, atol=0.08)


@pytest.mark.parametrize("content", ["a\tb\tword\n", "1.0\tnan\tword\n", "only\n"])
def test_a_damaged_table_of_words(tmp_path, content):
    (tmp_path / "a.tsv").write_text(content)
    if content == "only\n":
        assert transcripts.read(tmp_path / "a.tsv", np.zeros(16000, np.float32)) == []
        return
    with pytest.raises(CorpusUnreadable, match="transcript"):
        transcripts.read(tmp_path / "a.tsv", np.zeros(16000, np.float32))


def test_a_damaged_table_of_people(tmp_path):
    recording(tmp_path / "trn", "trn_2022_v1_000")
    (tmp_path / "trn" / "metadata.csv").write_bytes(b"\xf4\xff,1,2")
    with pytest.raises(CorpusUnreadable, match="metadata.csv is no readable table"):
        readers.genea(tmp_path)
