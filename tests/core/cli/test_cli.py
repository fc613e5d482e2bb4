"""The command line as a user meets it: exit status, one sentence on stderr, whole files or none."""

import json
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.cli import blender
from s2ag.core.cli.main import main
from s2ag.core.errors import BlenderUnavailable
from s2ag.core.motion.motion import Motion
from sounds import write_wav

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")


@pytest.fixture(autouse=True)
def show_mistakes(monkeypatch):
    """Mistakes of ours fail the test with their traceback instead of looking like a refused input."""
    monkeypatch.setenv("S2AG_DEBUG", "1")


@pytest.fixture
def voice(examples, tmp_path):
    """A copy of the shipped recording without a transcript beside it."""
    return Path(shutil.copy(examples / "hello.flac", tmp_path / "voice.flac"))


@pytest.fixture
def out(tmp_path):
    """An empty folder for outputs."""
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


@pytest.fixture
def refuse(capsys):
    """Runs a command line that must fail as the rules say; returns its sentence."""

    def run(*arguments):
        assert main([str(argument) for argument in arguments]) == 2
        told = capsys.readouterr()
        return one_sentence(told.err, told.out)

    return run


def one_sentence(err, out=""):
    lines = [line for line in err.splitlines() if not line.startswith("s2ag: note: ")]
    assert len(lines) == 1, err
    assert lines[0].startswith("s2ag: ")
    assert lines[0].endswith((".", "--help"))
    assert not out
    return lines[0]


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def silent_video(path):
    av = pytest.importorskip("av", reason="the engine is not installed")
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=10)
        stream.width = stream.height = 32
        stream.pix_fmt = "yuv420p"
        for _ in range(5):
            frame = av.VideoFrame.from_ndarray(np.zeros((32, 32, 3), np.uint8))
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
        container.mux(stream.encode())


def empty_wav(path):
    write_wav(path, [])


BAD_AUDIO = {
    "missing": (lambda path: None, ".wav"),
    "a folder": (lambda path: path.mkdir(), ".wav"),
    "no audio": (lambda path: path.write_text("these are not samples\n" * 50), ".mp3"),
    "zero bytes": (lambda path: path.write_bytes(b""), ".wav"),
    "zero samples": (empty_wav, ".wav"),
    "video without sound": (silent_video, ".mp4"),
}


@pytest.mark.parametrize("case", BAD_AUDIO)
def test_bad_audio(refuse, random_checkpoint, tmp_path, out, case):
    make, suffix = BAD_AUDIO[case]
    path = tmp_path / f"voice{suffix}"
    make(path)
    sentence = refuse("synth", path, "--checkpoint", random_checkpoint, "-o", out / "a.npz")
    assert str(path) in sentence
    assert not files(out)


def test_unknown_style_lists_the_near_ones(refuse, random_checkpoint, voice, out):
    sentence = refuse("synth", voice, "--checkpoint", random_checkpoint, "--style", "livly one", "-o", out / "a.npz")
    assert "livly one" in sentence
    assert "lively one" in sentence
    assert not files(out)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "no/such/folder/a.npz"], "no/such/folder"),
        (["-o", "OUT/a.txt"], ".npz"),
        (["-o", "OUT/a"], ".npz"),
        (["-o", "OUT/a.npz", "-o", "OUT/../out/a.npz"], "twice"),
        (["-o", "OUT/a.npz", "--text", "a", "--transcript", "b.txt"], "not allowed with"),
        (["-o", "OUT/a.npz", "--takes", "0"], "takes"),
        (["-o", "OUT/a.npz", "--seed", "-1"], "eed"),
        (["-o", "OUT/a.npz", "--seed", "x"], "seed"),
        (["-o", "OUT/a.npz", "--intensity", "-2"], "ntensity"),
        (["-o", "OUT/a.npz", "--intensity", "nan"], "ntensity"),
        (["-o", "OUT/a.npz", "--affect", "joy=0.5"], "arousal, valence, dominance"),
        (["-o", "OUT/a.npz", "--affect", "arousal=2"], "arousal cannot be 2"),
        (["-o", "OUT/a.npz", "--affect", "arousal"], "NAME=X"),
        (["-o", "OUT/a.npz", "--affect", "valence=0.5,arousal=much"], "arousal=much"),
        (["-o", "OUT/a.npz", "--rate", "1.5"], "rate cannot be 1.5"),
        (["-o", "OUT/a.npz", "--rate", "nan"], "rate"),
        (["-o", "OUT/a.npz", "--hand", "third"], "third"),
        (["-o", "OUT/a.npz", "--hand", "-3"], "hand cannot be -3"),
        (["-o", "OUT/a.npz", "--checkpoint", "none.safetensors"], "none.safetensors"),
        ([], "-o"),
    ],
)
def test_bad_options_of_synth(refuse, voice, out, arguments, said):
    """None of these needs a checkpoint: they are found before any work begins."""
    assert said in refuse("synth", voice, *(one.replace("OUT", str(out)) for one in arguments))
    assert not files(out)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--character", "robot"], "robot"),
        (["--character", "missing.blend"], "missing.blend"),
        (["--resolution", "wide"], "WIDTHxHEIGHT"),
        (["--resolution", "4x4"], "range"),
        (["--fps", "0"], "range"),
        (["--engine", "crayon"], "crayon"),
        (["-o", "OUT/a.npz"], ".mp4"),
    ],
)
def test_bad_options_of_animate(refuse, voice, out, arguments, said):
    assert said in refuse("animate", voice, "-o", out / "a.mp4", *(one.replace("OUT", str(out)) for one in arguments))
    assert not files(out)


def test_output_never_replaces_an_input(refuse, tmp_path):
    path = tmp_path / "scene.blend"
    path.write_bytes(b"precious")
    assert "input" in refuse("animate", tmp_path / "voice.wav", "--character", path, "-o", path)
    assert path.read_bytes() == b"precious"


@pytest.mark.parametrize("text", ['{"words": 3}', '[["a", 1]]', "[", '[["a", 2.0, 1.0]]'])
def test_bad_transcripts(refuse, random_checkpoint, voice, out, text):
    path = voice.with_suffix(".json")
    path.write_text(text)
    assert path.name in refuse("synth", voice, "--checkpoint", random_checkpoint, "--transcript", path, "-o", out / "a.npz")
    assert not files(out)


def test_missing_transcript(refuse, random_checkpoint, voice, out):
    assert "no.txt" in refuse("synth", voice, "--checkpoint", random_checkpoint, "--transcript", "no.txt", "-o", out / "a.npz")


def test_no_command_and_unknown_command(refuse):
    assert "COMMAND" in refuse()
    assert "dance" in refuse("dance")


def test_synth_writes_every_take_to_every_output(capsys, random_checkpoint, voice, out):
    arguments = ["synth", voice, "--checkpoint", random_checkpoint, "--takes", "2", "--text", "hello", "--style", "random"]
    outputs = [part for suffix in ("npz", "bvh", "json") for part in ("-o", out / f"a.{suffix}")]
    assert main([str(one) for one in arguments + outputs]) == 0
    assert files(out) == ["a-1.bvh", "a-1.json", "a-1.npz", "a-2.bvh", "a-2.json", "a-2.npz"]
    motions = [Motion.load(out / f"a-{take}.npz") for take in (1, 2)]
    assert not np.allclose(motions[0].directions, motions[1].directions)
    written = json.loads((out / "a-1.json").read_text())
    np.testing.assert_allclose(written["directions"], motions[0].directions, atol=1e-5)
    assert written["fps"] == motions[0].fps
    assert [tuple(word) for word in written["words"]] == list(motions[0].words)
    assert written["meta"]["style"] == "random"
    assert (out / "a-1.bvh").read_text().startswith("HIERARCHY")
    told = capsys.readouterr()
    assert told.out == ""
    assert all(line.startswith("s2ag: note: ") for line in told.err.splitlines())


def test_text_beside_the_recording_is_its_transcript(capsys, random_checkpoint, voice, examples, out):
    shutil.copy(examples / "hello.txt", voice.with_suffix(".txt"))
    run = ["synth", str(voice), "--checkpoint", str(random_checkpoint)]
    assert main([*run, "-o", str(out / "spoken.npz")]) == 0
    assert f"note: {voice.with_suffix('.txt')}" in capsys.readouterr().err
    assert main([*run, "--no-transcript", "-o", str(out / "sound.npz")]) == 0
    assert capsys.readouterr().err == ""
    assert len(Motion.load(out / "spoken.npz").words) > 5
    assert Motion.load(out / "sound.npz").words == ()


def test_same_command_same_motion(random_checkpoint, voice, out):
    for name in ("a", "b"):
        run = ["synth", voice, "--checkpoint", random_checkpoint, "--seed", "4", "-o", out / f"{name}.npz"]
        assert main([str(one) for one in run]) == 0
    np.testing.assert_array_equal(Motion.load(out / "a.npz").directions, Motion.load(out / "b.npz").directions)


def test_styles_lists_the_speakers_and_controls(capsys, random_checkpoint, plain_checkpoint):
    assert main(["styles", "--checkpoint", str(plain_checkpoint)]) == 0
    assert capsys.readouterr().out.splitlines() == ["calm one    small", "lively one  wide"]
    assert main(["styles", "--checkpoint", str(random_checkpoint)]) == 0
    told = capsys.readouterr().out
    assert told.startswith("calm one    small\nlively one  wide\n\n")
    assert all(option in told for option in ("--affect arousal=X", "--affect dominance=X", "--rate X", "--hand X"))
    assert main(["styles", "--json", "--checkpoint", str(random_checkpoint)]) == 0
    known = json.loads(capsys.readouterr().out)
    assert [style["name"] for style in known["styles"]] == ["calm one", "lively one"]
    assert [control["name"] for control in known["controls"]] == ["arousal", "valence", "dominance", "rate", "hand"]
    assert main(["styles", "--json", "--checkpoint", str(plain_checkpoint)]) == 0
    assert json.loads(capsys.readouterr().out)["controls"] == []


def test_controls_are_written_into_the_motion(random_checkpoint, voice, out):
    run = ["synth", str(voice), "--checkpoint", str(random_checkpoint), "-o", str(out / "a.npz")]
    assert (
        main([*run, "--affect", "arousal=0.8,Valence=-0.25", "--affect", "dominance=0.1", "--hand", "left", "--rate", "-1"])
        == 0
    )
    meta = Motion.load(out / "a.npz").meta
    assert meta["affect"] == {"arousal": 0.8, "valence": -0.25, "dominance": 0.1}
    assert (meta["hand"], meta["rate"]) == (-1, -1)


def test_controls_of_a_checkpoint_without_them(refuse, plain_checkpoint, voice, out):
    for control in (["--affect", "arousal=0.5"], ["--rate", "1"], ["--hand", "right"]):
        assert "no control of" in refuse("synth", voice, "--checkpoint", plain_checkpoint, *control, "-o", out / "a.npz")
    assert not files(out)


def test_doctor_reports_every_part(capsys):
    status = main(["doctor", "--json"])
    report = json.loads(capsys.readouterr().out)
    assert {"python", "torch", "pocketsphinx", "word vectors", "checkpoint", "blender", "rendering", "disk"} <= {
        check["name"] for check in report["checks"]
    }
    assert status == (0 if report["ok"] else 2)
    assert report["ok"] == all(check["ok"] for check in report["checks"] if check["required"])
    assert all(check["remedy"] for check in report["checks"] if not check["ok"])


@pytest.mark.parametrize("command", ["", "synth", "animate", "rig", "styles", "doctor"])
def test_help_has_an_example(capsys, command):
    assert main([*command.split(), "--help"]) == 0
    assert f"  s2ag {command}".rstrip() in capsys.readouterr().out.split("example")[1]


def limited(argument, *command):
    """The command line in a process of its own whose files cannot grow beyond so many bytes."""
    code = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)\n"
    code += "from s2ag.core.cli.main import main; sys.exit(main(sys.argv[2:]))"
    return subprocess.run([sys.executable, "-c", code, str(argument), *map(str, command)], capture_output=True, text=True)


@posix
@pytest.mark.parametrize("suffix", ["npz", "bvh", "json"])
def test_file_that_cannot_grow_leaves_nothing(random_checkpoint, voice, out, suffix):
    done = limited(2048, "synth", voice, "--checkpoint", random_checkpoint, "-o", out / f"a.{suffix}")
    assert done.returncode == 2
    assert f"a.{suffix}" in one_sentence(done.stderr, done.stdout)
    assert not files(out)


@posix
def test_full_disk_leaves_nothing(refuse, random_checkpoint, voice, out):
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "tmpfs", out], capture_output=True)
    if mounted.returncode:
        pytest.skip("mounting a tiny file system is not permitted here")
    try:
        sentence = refuse("synth", voice, "--checkpoint", random_checkpoint, "-o", out / "a.npz")
        assert "No space left" in sentence
        assert not files(out)
    finally:
        subprocess.run(["umount", out], check=True)


def test_installed_command_speaks_one_sentence(tmp_path):
    arguments = [sys.executable, "-m", "s2ag", "synth", "none.wav", "-o", "none/a.npz"]
    done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert "folder" in one_sentence(done.stderr, done.stdout)


@posix
def test_bar_on_a_terminal_and_none_in_a_pipe(tmp_path):
    pytest.importorskip("tqdm", reason="the engine is not installed")
    import pty

    code = "from s2ag.core.cli.progress import Progress\nwith Progress() as p:\n    p('align', 0.2)\n    p('generate', 1.0)"
    ours, theirs = pty.openpty()
    subprocess.run([sys.executable, "-c", code], stderr=theirs, check=True)
    os.write(theirs, b"end")  # so that reading never waits, whatever was shown
    shown = os.read(ours, 65536).decode()
    os.close(theirs)
    os.close(ours)
    assert "generate" in shown
    assert "100%" in shown
    assert subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, check=True).stderr == b""


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
    assert blender.run("film.job", "x", progress=lambda *said: heard.append(said))["outputs"] == []
    assert heard == [("render", 0.5)]
    assert capsys.readouterr() == ("", "")


@posix
def test_blenders_own_error_is_the_sentence(fake_blender, capsys):
    fake_blender(
        'print(\'{"event": "error", "kind": "RigUnusable", "message": "It has no arms.", "remedy": "Add some."}\')\nsys.exit(1)'
    )
    with pytest.raises(Exception, match="It has no arms. Add some.") as caught:
        blender.run("film.job", "x")
    assert caught.value.kind == "RigUnusable"
    assert capsys.readouterr().err == ""


@posix
def test_dead_blender_shows_its_last_words(fake_blender, capsys):
    fake_blender('print("drawing", flush=True)\nprint("no GPU", file=sys.stderr, flush=True)\nos.kill(os.getpid(), 9)')
    with pytest.raises(BlenderUnavailable, match="killed by signal 9"):
        blender.run("film.job", "x")
    assert capsys.readouterr().err.split("\n")[:2] == ["drawing", "no GPU"]


@posix
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
