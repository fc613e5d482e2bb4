"""Motions that are there already: onto a character without an engine, and straight into a study."""

import json

import numpy as np
import pytest
from refusals import files
from s2ag.core.cli.main import main
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.motion.readers import motion_files
from s2ag.rigs import bvh
from sounds import write_wav

ARMS = [skeleton.EDGE_NAMES.index(f"{side}_{part}") for side in ("left", "right") for part in ("upper_arm", "forearm")]


@pytest.fixture
def motion():
    """One second in which both forearms go up and down."""
    directions = np.tile(skeleton.MEAN_UNIT, (15, 1, 1))
    directions[:, ARMS[1::2], 1] += np.sin(np.linspace(0, 2 * np.pi, 15))[:, None]
    return Motion(skeleton.normalize(directions).astype(np.float32), skeleton.FPS, meta={"made": "here"})


def degrees(one, other):
    return np.degrees(np.arccos(np.clip((one * other).sum(-1), -1, 1)))


def test_our_own_files_are_read_as_they_were_written(motion, tmp_path):
    motion.save(tmp_path / "a.npz")
    bvh.save(motion, tmp_path / "a.bvh")
    np.testing.assert_array_equal(motion_files.load(tmp_path / "a.npz").directions, motion.directions)
    read = motion_files.load(tmp_path / "a.bvh")
    assert read.fps == pytest.approx(15) and len(read.directions) == 15
    # A skeleton without hips is turned until its shoulders lie along x; head and neck are set up anew (readers/ten_joints.py).
    across = skeleton.canonical_to_y_up(skeleton.to_positions(motion.directions))
    across = across[:, skeleton.JOINTS.index("left_shoulder")] - across[:, skeleton.JOINTS.index("right_shoulder")]
    turn = np.degrees(np.abs(np.arctan2(across[:, 2], across[:, 0]))).max()
    assert degrees(read.directions, motion.directions)[:, ARMS].max() < turn + 0.05  # single precision near a cosine of 1


@pytest.mark.parametrize("kind", [".npz", ".bvh"])
def test_a_motion_goes_onto_a_character_without_an_engine(motion, tmp_path, out, kind):
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    path = tmp_path / f"a{kind}"
    motion.save(path) if kind == ".npz" else bvh.save(motion, path)
    command = ["animate", path, "--character", "mannequin", "--fps", "15", "-o", out / "a.bvh"]
    assert main([str(one) for one in command]) == 0
    made = motion_files.load(out / "a.bvh")
    assert len(made.directions) == 15
    assert degrees(made.directions, motion.directions)[:, ARMS].max() < 1  # a figure's own shoulders are elsewhere


def test_what_would_make_a_motion_is_refused_beside_one(refuse, motion, voice, tmp_path, out):
    motion.save(tmp_path / "a.npz")
    common = ["animate", tmp_path / "a.npz", "--character", "mannequin", "-o", out / "a.blend"]
    assert "--style, --seed" in refuse(*common, "--style", "calm", "--seed", "3")
    assert "--from" in refuse(*common, "--from", "sheet.json:2")
    assert "no joint" in refuse("animate", strange(tmp_path / "b.bvh"), "-o", out / "a.blend")
    assert "is missing" in (told := refuse("animate", tmp_path / "none.npz", "-o", out / "a.blend")) or "no" in told
    assert "belongs to a motion" in refuse("animate", voice, "--sound", voice, "-o", out / "a.blend")
    assert not files(out)


def strange(path):
    path.write_text(
        "HIERARCHY\nROOT Tail\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
        "MOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0\n"
    )
    return path


@pytest.mark.slow
def test_motions_go_straight_into_a_study(motion, tmp_path, capsys):
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    from s2ag.s2ag_blender.render import opengl

    if not opengl.is_available():
        pytest.skip("this machine offers no OpenGL, not even in software")
    clips, speech = tmp_path / "clips", tmp_path / "speech"
    for name in ("ours", "theirs"):
        (clips / name).mkdir(parents=True)
    speech.mkdir()
    motion.save(clips / "ours" / "01.npz")
    (clips / "theirs" / "01.mp4").write_bytes(b"a film")
    command = ["study", "make", str(clips), "-o", str(tmp_path / "study"), "--character", "mannequin"]
    assert main(command) == 2 and "01.npz has no recording" in capsys.readouterr().err
    write_wav(speech / "01.wav", np.sin(np.arange(16000) / 20) * 0.2)
    assert main([*command, "--speech", str(speech)]) == 0
    key = json.loads((tmp_path / "study" / "key.json").read_text())
    shown = {one["condition"]: tmp_path / "study" / "page" / "clips" / name for name, one in key["clips"].items()}
    assert shown["theirs"].read_bytes() == b"a film" and shown["ours"].read_bytes()[4:8] == b"ftyp"
    assert sorted(path.name for path in (clips / "ours").iterdir()) == ["01.npz"]
