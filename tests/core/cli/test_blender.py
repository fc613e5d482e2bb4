"""Blender as the command line starts it: heard through its chatter, interrupted, missing, and at work."""

import os
import stat
import sys
import tempfile
from pathlib import Path

import pytest
from refusals import files, one_sentence
from s2ag.core.cli import blender
from s2ag.core.cli.main import main
from s2ag.core.errors import BlenderUnavailable

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")


@pytest.fixture
def fake_blender(tmp_path, monkeypatch):
    """Lets S2AG_BLENDER name a program that does as the script says."""

    def make(script):
        path = tmp_path / "blender"
        path.write_text(f"#!{sys.executable}\nimport os, sys, time\n{script}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("S2AG_BLENDER", str(path))

    return make


@posix
def test_blender_is_heard_through_its_chatter(fake_blender, capsys):
    fake_blender(
        'print("Fra:1 Mem:9M")\nprint(\'{"event": "progress", "stage": "render", "value": 0.5}\')\n'
        'print("{broken")\nprint(\'{"event": "result", "outputs": []}\')\nprint("Blender quit", flush=True)\nos.abort()'
    )
    heard = []
    assert blender.run("render.job", "x", progress=lambda *said: heard.append(said))["outputs"] == []
    assert heard == [("render", 0.5)]
    assert capsys.readouterr() == ("", "")


@posix
def test_blenders_own_error_is_the_sentence(fake_blender, capsys):
    fake_blender(
        'print(\'{"event": "error", "kind": "RigUnusable", "message": "It has no arms.", "remedy": "Add some."}\')\nsys.exit(1)'
    )
    with pytest.raises(Exception, match="It has no arms. Add some.") as caught:
        blender.run("render.job", "x")
    assert caught.value.kind == "RigUnusable"
    assert capsys.readouterr().err == ""


@posix
def test_dead_blender_shows_its_last_words(fake_blender, capsys):
    fake_blender('print("drawing", flush=True)\nprint("no GPU", file=sys.stderr, flush=True)\nos.kill(os.getpid(), 9)')
    with pytest.raises(BlenderUnavailable, match="killed by signal 9"):
        blender.run("render.job", "x")
    assert capsys.readouterr().err.split("\n")[:2] == ["drawing", "no GPU"]


@posix
def test_only_a_folder_of_its_own_goes_with_a_command(tmp_path):
    assert blender._own_folder() == blender._own_folder("job.json") == blender._own_folder(str(tmp_path / "s2ag-x" / "j")) == ""
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        assert blender._own_folder(f"{folder}/job.json") == str(Path(folder).absolute())


def test_interrupt_ends_blender_and_is_status_130(fake_blender, capsys, tmp_path, interruptible):
    note = tmp_path / "pid"
    fake_blender(f'open({str(note)!r}, "w").write(str(os.getpid()))\nos.kill(os.getppid(), 2)\ntime.sleep(60)')
    assert main(["doctor"]) == 130
    assert capsys.readouterr().err == "s2ag: interrupted.\n"
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)


def test_blender_that_is_not_there(refuse, monkeypatch, voice, out):
    monkeypatch.setenv("S2AG_BLENDER", "/no/such/blender")
    assert "/no/such/blender" in refuse("animate", voice, "-o", out / "a.mp4")
    assert not files(out)


def test_real_blender_answers_the_probe():
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    assert blender.run("probe")["blender"].count(".") == 2


def test_animate_makes_a_character_in_blender(capfd, random_checkpoint, voice, out):
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    run = ["animate", voice, "--checkpoint", random_checkpoint, "--character", "mannequin", "--takes", "2", "--fps", "30"]
    assert main([str(one) for one in [*run, "-o", out / "a.blend", "-o", out / "a.bvh"]]) == 0
    assert files(out) == ["a-1.blend", "a-1.bvh", "a-2.blend", "a-2.bvh"]
    assert (out / "a-1.bvh").read_text().startswith("HIERARCHY")
    assert (out / "a-1.bvh").read_text() != (out / "a-2.bvh").read_text()
    told = capfd.readouterr()
    assert told.out == ""
    assert all(line.startswith("s2ag: note: ") for line in told.err.splitlines())


def test_character_that_cannot_gesture(capfd, random_checkpoint, voice, out, tmp_path):
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    broken = tmp_path / "broken.blend"
    broken.write_bytes(b"BLENDER no more")
    run = ["animate", voice, "--checkpoint", random_checkpoint, "--character", broken, "-o", out / "a.blend"]
    assert main([str(one) for one in run]) == 2
    told = capfd.readouterr()
    assert "broken.blend" in one_sentence(told.err, told.out)
    assert not files(out)
