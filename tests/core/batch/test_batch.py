"""Batches that need no Blender: repeatable, restartable after any kill, and one bad clip fails alone."""

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from rounding import bound
from s2ag.core import files
from s2ag.core.batch import folder
from s2ag.core.cli.main import main
from s2ag.core.errors import S2agError
from s2ag.core.model import loading
from s2ag.core.motion.motion import Motion
from sounds import write_wav

pytest.importorskip("torch", reason="the engine is not installed")
posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")


@pytest.fixture(autouse=True)
def show_mistakes(monkeypatch):
    monkeypatch.setenv("S2AG_DEBUG", "1")


@pytest.fixture(scope="module")
def speech(examples):
    """Samples of the shipped recording at 16 kHz."""
    from s2ag.core.sound import audio

    return audio.load(examples / "hello.flac")


@pytest.fixture
def manifest(tmp_path, speech):
    """A function that writes recordings of a second or two and a manifest of them."""

    def make(count, **columns):
        rows = []
        for number in range(1, count + 1):
            write_wav(tmp_path / f"{number}.wav", speech[16000 * (number % 8) : 16000 * (number % 8 + 2)])
            rows.append({"name": f"clip{number}", "audio": f"{number}.wav", "seed": number, **columns})
        path = tmp_path / "clips.jsonl"
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
        return path

    return make


@pytest.fixture
def batch(flow_checkpoint, tmp_path):
    """A function that runs ``s2ag batch``."""

    def run(verb, *arguments, out="out"):
        return main(["batch", verb, *map(str, arguments), "-o", str(tmp_path / out), "--checkpoint", str(flow_checkpoint)])

    return run


def results(place):
    """Digest of every motion and BVH file."""
    files = [path for kind in ("npz", "bvh") for path in (place / kind).glob("*")]
    return {path.relative_to(place).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(files)}


def leftovers(place):
    return [path for path in place.rglob("*") if path.name.startswith(".") and path.is_file()] + list(place.glob(".part/*"))


def test_a_run_makes_everything_and_a_second_makes_nothing(manifest, batch, tmp_path, capsys):
    path = manifest(3, takes=2, outputs=["bvh", "json"])
    assert batch("run", path, "-j", 2) == 0
    out = tmp_path / "out"
    names = [f"clip{number}-{take}" for number in (1, 2, 3) for take in (1, 2)]
    assert sorted(one.stem for one in (out / "bvh").iterdir()) == names == sorted(one.stem for one in (out / "json").iterdir())
    assert Motion.load(out / "npz" / "clip2-1.npz").meta["seed"] == 2
    stock = json.loads((out / "summary.json").read_text())
    assert stock["complete"] and stock["stages"]["synth"]["done"] == 3 and stock["last_run"]["tried"] == 3
    before = {one: one.stat().st_mtime_ns for one in out.rglob("*.bvh")}
    assert batch("run", path) == 0 and batch("run", "--resume") == 0
    assert json.loads((out / "summary.json").read_text())["last_run"]["tried"] == 0
    assert {one: one.stat().st_mtime_ns for one in out.rglob("*.bvh")} == before
    assert not leftovers(out) and not (out / "failures.jsonl").exists()
    assert "complete: synth 3 of 3" in capsys.readouterr().err


def test_only_what_has_changed_is_made_again(manifest, batch, tmp_path):
    path = manifest(3)
    assert batch("run", path, "-j", 1) == 0
    before = results(tmp_path / "out")
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    rows[1]["seed"] = 77
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    (tmp_path / "out" / "bvh" / "clip3.bvh").unlink()
    assert batch("run", path, "-j", 1) == 0
    after = results(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["last_run"]["tried"] == 2
    assert {name for name in after if after[name] != before[name]} == {"npz/clip2.npz", "bvh/clip2.bvh"}


@pytest.mark.slow
def test_a_change_of_models_is_a_change_of_what_uses_them(manifest, batch, tmp_path, flow_checkpoint, plain_checkpoint):
    def tried(*arguments):
        assert batch("run", *arguments, "-j", 1) == 0
        return json.loads((tmp_path / "out" / "summary.json").read_text())["last_run"]["tried"]

    path = manifest(2)
    path.write_text(path.read_text().replace('"seed": 1', '"seed": 1, "text": "hello"'))
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "own.dict").write_text("hello HH AH L OW\n")
    assert tried(path) == 2 and tried("--resume") == 0
    assert main(["batch", "run", "--resume", "-o", str(tmp_path / "out")]) == 0  # the plan knows the checkpoint
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["last_run"]["tried"] == 0
    assert tried(path, "--aligner-model", tmp_path / "model") == 1  # the clip with words
    assert tried("--resume", "--cache", "off") == 0
    (tmp_path / "model" / "own.dict").write_text("hello HH EH L OW\n")
    assert tried("--resume") == 1
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    rows[1]["checkpoint"] = str(plain_checkpoint)
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    assert tried(path, "--aligner-model", tmp_path / "model") == 1
    made = [Motion.load(tmp_path / "out" / "npz" / f"clip{number}.npz").meta["checkpoint"] for number in (1, 2)]
    assert made[0] != made[1]


def test_a_chosen_cell_is_made_in_a_batch(batch, tmp_path, flow_checkpoint, examples):
    common = ["--checkpoint", str(flow_checkpoint)]
    sheet = tmp_path / "sheet.json"
    assert main(["sample", str(examples / "hello.flac"), "--no-transcript", "--takes", "3", "-o", str(sheet), *common]) == 0
    assert main(["synth", "--from", f"{sheet}:3", "--no-transcript", "-o", str(tmp_path / "alone.npz"), *common]) == 0
    (tmp_path / "cells.csv").write_text("cell,name\nsheet.json:3,chosen\n")
    assert batch("run", tmp_path / "cells.csv") == 0
    alone, made = Motion.load(tmp_path / "alone.npz"), Motion.load(tmp_path / "out" / "npz" / "chosen.npz")
    limit = bound(loading.load(flow_checkpoint))  # another batch size, other threads
    assert made.meta == alone.meta and abs(made.directions - alone.directions).max() < limit


@pytest.mark.slow
def test_slices_together_are_the_whole(manifest, batch, tmp_path):
    path = manifest(5)
    assert batch("run", path, "-j", 2, out="whole") == 0
    assert batch("plan", path) == 0
    plan = tmp_path / "out" / "plan.jsonl"
    for part in ("3/3", "1/3", "2/3"):
        assert batch("synth", plan, "--slice", part, "-j", 1) == 0
    assert results(tmp_path / "out") == results(tmp_path / "whole")
    assert batch("status", plan) == 0 and batch("status") == 0


def test_a_slice_may_be_empty(manifest, batch, capsys):
    path = manifest(2)
    assert batch("synth", path, "--clips", "50-60") == 0 and batch("status", path, "--slice", "1/100") == 0
    assert capsys.readouterr().err.count("no clips in this part") == 2


def test_what_many_lines_have_in_common_is_said_once(manifest, batch, capsys):
    assert batch("run", manifest(5), "--style", "nobody") == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2 and "clips.jsonl:1: " in said[0] and "The same goes for 4 more." in said[0]


def test_warnings_are_listed(manifest, batch, tmp_path, capsys):
    path = manifest(2, text="These are words that nobody says here, and there are far too many of them for two seconds of it.")
    assert batch("run", path) == 0
    assert "2 clips were made with warnings" in capsys.readouterr().err
    rows = [json.loads(line) for line in (tmp_path / "out" / "warnings.jsonl").read_text().splitlines()]
    assert [row["name"] for row in rows] == ["clip1", "clip2"] and all("transcript" in row["message"] for row in rows)


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_is_not_a_failure(manifest, tmp_path, flow_checkpoint, number):
    path, out = manifest(12, takes=8), tmp_path / "out"
    command = [sys.executable, "-m", "s2ag", "batch", "run", path, "-o", out, "-j", "2", "--checkpoint", flow_checkpoint]

    def as_on_a_terminal():
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=as_on_a_terminal)
    deadline = time.monotonic() + 120
    while not list(out.glob("records/synth/*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, number)  # Ctrl-C reaches all of the group
    told = process.communicate()[1]
    assert process.returncode == 130 and told.endswith("s2ag: interrupted.\n") and "failed" not in told
    assert not (out / "records" / "synth-failed").exists() and len(results(out)) < 12 * 8 * 2


def test_status_tells_what_is_missing(manifest, batch, capsys):
    path = manifest(3)
    assert batch("synth", path, "--clips", "2") == 0
    capsys.readouterr()
    assert batch("status", path) == 1
    assert "not complete: synth 1 of 3" in capsys.readouterr().err
    assert batch("status", path, "--clips", "2") == 0


def test_a_poisoned_clip_fails_alone_and_is_tried_again(manifest, batch, tmp_path, capsys):
    path = manifest(4)
    whole = (tmp_path / "2.wav").read_bytes()
    (tmp_path / "2.wav").write_bytes(whole[:9000])  # cut off: the header opens, the samples end too soon
    assert batch("run", path, "-j", 2) == 1
    assert "line 2: clip2 failed to synth" in capsys.readouterr().err
    out = tmp_path / "out"
    (failure,) = [json.loads(line) for line in (out / "failures.jsonl").read_text().splitlines()]
    assert failure["name"] == "clip2" and failure["kind"] == "AudioUnreadable" and failure["line"] == 2
    assert {one.stem for one in (out / "bvh").iterdir()} == {"clip1", "clip3", "clip4"}
    assert batch("synth", path, "--clips", "2", "--tolerate") == 0
    assert batch("status", path) == 1
    (tmp_path / "2.wav").write_bytes(whole)
    assert batch("run", path) == 0
    assert not (out / "failures.jsonl").exists() and len(list((out / "bvh").iterdir())) == 4


def test_a_wrong_manifest_starts_nothing(manifest, batch, tmp_path, capsys):
    path = manifest(2)
    (tmp_path / "2.wav").unlink()
    path.write_text(path.read_text() + '{"audio": "1.wav", "style": "nobody"}\n')
    assert batch("run", path) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 3 and ":2: " in said[0] and ":3: " in said[1] and "2 problems" in said[2]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments", [("run",), ("synth",), ("run", "--resume"), ("status",), ("run", "x.csv", "--slice", "2")]
)
def test_usage_errors(batch, arguments, capsys):
    assert batch(*arguments) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.slow
@posix
def test_killed_at_random_moments_it_ends_as_if_nothing_had_been(manifest, batch, tmp_path, flow_checkpoint):
    path = manifest(8, takes=2)
    assert batch("run", path, "-j", 2, out="calm") == 0
    calm, out = results(tmp_path / "calm"), tmp_path / "out"
    command = [sys.executable, "-m", "s2ag", "batch", "run", path, "-o", out, "-j", "2", "--checkpoint", flow_checkpoint]
    chance = random.Random(7)
    for _ in range(4):
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(1.0, 5.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert all(results(out)[name] == calm[name] for name in results(out))
    assert batch("run", path, "-j", 2) == 0
    assert results(out) == calm
    deadline = time.monotonic() + 20  # children of the last kill may still be on their way out
    while leftovers(out) and time.monotonic() < deadline:
        time.sleep(0.5)
        folder.Folder(out).sweep()
    assert not leftovers(out)


def test_the_data_set_holds_motion_sound_and_words(manifest, batch, tmp_path):
    import wave

    import numpy as np

    assert batch("run", manifest(3, takes=2, outputs="dataset", text="hello there")) == 0
    place = tmp_path / "out" / "dataset"
    rows = [json.loads(line) for line in (place / "index.jsonl").read_text().splitlines()]
    assert [row["name"] for row in rows] == [f"clip{n}-{take}" for n in (1, 2, 3) for take in (1, 2)]
    assert {row["split"] for row in rows} <= {"train", "validation", "test"}
    for row in rows:
        with np.load(place / row["motion"]) as motion, wave.open(str(place / row["audio"])) as sound:
            assert motion["directions"].shape[1:] == (9, 3) and motion["positions"].shape[1:] == (10, 3)
            assert sound.getframerate() == 16000 and abs(sound.getnframes() / 16000 - len(motion["directions"]) / 15) < 0.1
        assert [word for word, *_ in json.loads((place / row["words"]).read_text())["words"]] == ["hello", "there"]
    assert "left_elbow" in (place / "README.md").read_text()


def test_records_hold_only_for_their_key_and_files(tmp_path):
    place = folder.Folder(tmp_path)
    (tmp_path / "a.txt").write_text("four")
    record = place.record("synth", "a")
    record.fail("k", S2agError("Bad.", "Try."))
    record.write("k", [tmp_path / "a.txt"], {"x": 1})
    assert record.read("k") == {"x": 1} and record.read("other") is None and record.failure() is None
    for content in ("longer", "\0\0\0\0"):  # a crash may leave as many zeros
        (tmp_path / "a.txt").write_text(content)
        assert record.read("k") is None
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "1.png").write_text("four")
    record.write("k", [tmp_path / "frames"], {})
    assert record.read("k") == {}
    (tmp_path / "frames" / "1.png").write_bytes(bytes(4))
    assert record.read("k") is None
    record.path.write_text("{ half")
    assert record.read("k") is None


def test_folders_and_files_land_over_what_was_there(tmp_path):
    place = folder.Folder(tmp_path)
    for content in ("one", "two"):
        with place.part() as part:
            (part / "seq").mkdir()
            (part / "seq" / "1.png").write_text(content)
            (part / "a.bvh").write_text(content)
            folder.move_to_place(part / "seq", tmp_path / "frames" / "seq")
            folder.move_to_place(part / "a.bvh", tmp_path / "bvh" / "a.bvh")
        assert (tmp_path / "frames" / "seq" / "1.png").read_text() == (tmp_path / "bvh" / "a.bvh").read_text() == content
    assert not list((tmp_path / ".part").iterdir())


def test_sweeping_spares_the_living(tmp_path):
    place = folder.Folder(tmp_path)
    parts = tmp_path / ".part"
    elsewhere = [f"{files.TEMPORARY_PREFIX}elsewhere@1@{name}" for name in ("new", "old")]
    code = f"import os; from s2ag.core.batch.folder import Folder\nwith Folder({str(tmp_path)!r}).part(): os._exit(1)"
    subprocess.run([sys.executable, "-c", code], check=False)
    assert len(list(parts.iterdir())) == 2
    for name in elsewhere:
        (parts / name).mkdir()
    os.utime(parts / elsewhere[1], (0, 0))
    with folder.Folder(tmp_path).part() as mine:
        place.sweep()
        assert {path.name for path in parts.iterdir()} == {mine.name, f"{mine.name}.lock", elsewhere[0]}


def test_a_slice_of_a_farm_writes_the_summary_of_all(manifest, batch, tmp_path):
    path = manifest(4)
    assert batch("synth", path, "--slice", "1/2") == 0
    stock = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert stock["stages"]["synth"] == {"steps": 4, "done": 2, "failed": 0, "ready": 2, "waiting": 0}
