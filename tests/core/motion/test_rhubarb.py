"""Mouth cues as Rhubarb writes them, both ways."""

import json

import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.learning.evaluate.faces import lips_closed
from s2ag.core.motion import rhubarb
from s2ag.core.motion.face import channel
from s2ag.core.motion.motion import Motion

TOLD = [("X", 0.0, 0.2), ("A", 0.2, 0.3), ("D", 0.3, 0.6), ("F", 0.6, 0.9), ("X", 0.9, 1.0)]


@pytest.mark.parametrize("suffix", rhubarb.SUFFIXES)
def test_cues_become_a_mouth_and_come_back(suffix, examples, tmp_path):
    path = tmp_path / f"mouth{suffix}"
    if suffix == ".tsv":
        path.write_text("".join(f"{start:.2f}\t{shape}\n" for shape, start, _ in TOLD) + "1.00\tX\n")
    else:
        cues = [{"start": start, "end": end, "value": shape} for shape, start, end in TOLD]
        path.write_text(json.dumps({"metadata": {"soundFile": "a.wav", "duration": 1.0}, "mouthCues": cues}))
    told = rhubarb.load(path)
    assert [cue for cue in told if cue[2] > cue[1]] == TOLD
    weights, closures = rhubarb.mouth_weights(told, 1.0)
    assert closures.tolist() == [[0.2, 0.3]] and lips_closed(weights[20:30]).all() and not weights[:16].any()
    assert weights[45, channel("JAW")] > 0.6 and weights[75, channel("OU")] > 0.8 and not lips_closed(weights[40])


def test_the_command_line_takes_and_writes_cues(examples, tmp_path):
    made = [tmp_path / name for name in ("a.npz", "a.tsv", "a.rhubarb.json")]
    outputs = [part for path in made for part in ("-o", str(path))]
    assert main(["synth", str(examples / "hello.flac"), "--face", *outputs]) == 0
    face = Motion.load(made[0]).face
    told = rhubarb.load(made[1])
    ours = [pytest.approx(cue[1:], abs=0.011) for cue in rhubarb.load(made[2])]
    assert ours == [cue[1:] for cue in told if cue[2] > cue[1]] and {shape for shape, *_ in told} <= set("ABCDEFGHX")
    assert sum(shape == "A" for shape, *_ in told) >= len(face.closures) - 1
    again = tmp_path / "b.npz"
    assert main(["synth", str(examples / "hello.flac"), "--face", "--rhubarb", str(made[1]), "-o", str(again)]) == 0
    other = Motion.load(again).face
    eyes = channel("LOOK_LEFT")
    assert np.abs(other.weights[:, eyes] - face.weights[:, eyes]).max() < 1e-6
    middles = (face.closures.mean(1) * 100).round().astype(int)
    assert lips_closed(other.weights[middles]).all()
    jaws = np.corrcoef(other.weights[:, channel("JAW")], face.weights[:, channel("JAW")])[0, 1]
    assert jaws > 0.5


@pytest.mark.parametrize("text", ["", "0.0\tQ\n", "x\tA\n", "1.0\tA\n0.5\tB\n", "nan\tA\n", "0.0 A\n"])
def test_other_files_are_refused_in_a_sentence(text, tmp_path):
    (tmp_path / "a.tsv").write_text(text)
    with pytest.raises(UsageError):
        rhubarb.load(tmp_path / "a.tsv")
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(UsageError):
        rhubarb.load(tmp_path / "a.json")


def test_cues_without_a_face_are_refused(examples, tmp_path, capsys):
    assert main(["synth", str(examples / "hello.flac"), "-o", str(tmp_path / "a.tsv")]) == 2
    assert "Add --face" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["0.0\tA\n1e300\tX\n", "-1\tA\n", "0\tA\n" * 200_001])
def test_times_beyond_any_recording_and_cues_without_end_are_refused(text, tmp_path):
    (tmp_path / "a.tsv").write_text(text)
    with pytest.raises(UsageError):
        rhubarb.load(tmp_path / "a.tsv")
