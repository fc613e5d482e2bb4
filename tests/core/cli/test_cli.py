"""The command line as a user meets it: exit status, one sentence on stderr, whole files or none."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from refusals import files, one_sentence
from s2ag.core.cli.main import main
from s2ag.core.motion.motion import Motion
from sounds import write_wav

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")


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
    command = [sys.executable, "-B", "-c", code, str(argument), *map(str, command)]  # no half of a module's bytecode is cached
    return subprocess.run(command, capture_output=True, text=True)


@posix
@pytest.mark.parametrize("suffix", ["npz", "bvh", "json"])
def test_file_that_cannot_grow_leaves_nothing(flow_checkpoint, voice, out, suffix):
    done = limited(2048, "synth", voice, "--checkpoint", flow_checkpoint, "-o", out / f"a.{suffix}")
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
    import pty

    code = "from s2ag.core.cli.progress import Progress\nwith Progress() as p:\n    p('align', 0.2)\n    p('generate', 1.0)"
    ours, theirs = pty.openpty()
    subprocess.run([sys.executable, "-c", code], stderr=theirs, check=True)
    os.write(theirs, b"end")  # so that reading never waits, whatever was shown
    shown = ""
    while "end" not in shown:  # a busy kernel hands it over in pieces
        shown += os.read(ours, 65536).decode()
    os.close(theirs)
    os.close(ours)
    assert "generate" in shown
    assert "100%" in shown
    assert subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, check=True).stderr == b""


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_a_console_that_knows_few_letters_is_told_all_the_same(tmp_path, encoding):
    """As those of Windows, to which what they could not show was a mistake of ours."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "S2AG_CACHE": str(tmp_path / "кэш")}
    command = [sys.executable, "-m", "s2ag.core.cli.main", "doctor", "--clear-cache"]
    done = subprocess.run(command, capture_output=True, env=environment)
    assert done.returncode == 0 and b"0 files removed" in done.stdout and rb"\u043a" in done.stdout
