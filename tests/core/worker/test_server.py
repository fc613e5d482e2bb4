"""The real worker process, spoken to over its pipes."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from s2ag.core import errors
from s2ag.core.files import TEMPORARY_PREFIX
from s2ag.core.motion.motion import Motion
from s2ag.core.worker import protocol
from sounds import write_wav

ROOT = Path(__file__).parents[3]


class Pipe:
    """A worker and the two ends of its protocol."""

    def __init__(self, **options):
        command = [sys.executable, "-m", f"{ROOT.name}.core.worker.server"]
        self.process = subprocess.Popen(
            command, cwd=ROOT.parent, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
        )

    def say(self, *lines):
        for line in lines:
            self.process.stdin.write(line if isinstance(line, bytes) else protocol.encode(line))
        self.process.stdin.flush()

    def hear(self, want="result"):
        """The next message that has ``want``."""
        while line := self.process.stdout.readline():
            message = json.loads(line)
            if want in message:
                return message
        raise AssertionError(f"the worker ended: {self.process.stderr.read().decode()}")

    def ended(self):
        return self.process.wait(20)


@pytest.fixture
def worker():
    pipe = Pipe()
    yield pipe
    pipe.process.kill()
    pipe.process.communicate()


@pytest.fixture(scope="module")
def sturdy():
    """One worker for all that is refused: it survives every request before the next one."""
    pipe = Pipe()
    yield pipe
    pipe.process.kill()
    pipe.process.communicate()


def test_hello_tells_version_and_loads_nothing_heavy(worker):
    worker.say({"id": 1, "method": "hello"})
    result = worker.hear()["result"]
    assert result["protocol"] == protocol.VERSION
    assert result["version"].count(".") == 2
    assert isinstance(result["styles"], list) and isinstance(result["controls"], list)
    maps = Path(f"/proc/{worker.process.pid}/maps")
    if maps.exists():
        assert "libtorch" not in maps.read_text()


@pytest.mark.parametrize(
    "line",
    [
        b"hello\n",
        b"[1, 2]\n",
        b'{"id": 3,\n',
        b"\xff\xfe\x00\n",
        b"[" * 100_000 + b"\n",
        b'{"method": "hello"}\n',
        b'{"id": [], "method": "hello"}\n',
    ],
    ids=["word", "list", "cut", "bytes", "deep", "no id", "odd id"],
)
def test_garbage_is_answered_and_survived(sturdy, line):
    sturdy.say(line, {"id": 2, "method": "hello"})
    refusal = sturdy.hear("error")
    assert refusal["id"] is None
    assert refusal["error"]["kind"] == "BadRequest"
    assert sturdy.hear()["id"] == 2


def test_a_line_of_60_megabytes_takes_no_memory(worker):
    worker.say({"id": 1, "method": "hello"})
    worker.hear()
    status = Path(f"/proc/{worker.process.pid}/status")
    worker.say(*[b"[" * 1_000_000] * 60, b"\n", {"id": 2, "method": "hello"})
    assert worker.hear("error")["error"]["kind"] == "BadRequest" and worker.hear()["id"] == 2
    if status.exists():
        (peak,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        assert int(peak.split()[1]) * 1024 < 5 * protocol.LARGEST + 100_000_000


def test_empty_lines_are_no_requests(sturdy):
    sturdy.say(b"\n \n", {"id": 5, "method": "hello"})
    assert sturdy.hear("id")["id"] == 5


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({}, "no audio"),
        ({"audio": 3}, "audio"),
        ({"audio": "a.wav", "seed": "x"}, "seed"),
        ({"audio": "a.wav", "seed": True}, "seed"),
        ({"audio": "a.wav", "speed": 2}, "speed"),
        ({"audio": "a.wav", "takes": 0}, "takes"),
        ({"audio": "a.wav", "affect": [0.5]}, "affect"),
        ({"audio": "a.wav", "affect": {"joy": 1}}, "joy"),
        ({"audio": "a.wav", "affect": {"arousal": "high"}}, "arousal"),
        ({"audio": "a.wav", "rate": 7}, "rate"),
        ({"audio": "a.wav", "hand": "left"}, "hand"),
        ({"audio": "a.wav", "text": "a", "transcript": "b"}, "transcript"),
        ({"audio": "a.wav", "pose": [[1, 0, 0]]}, "nine directions"),
        ({"audio": "a.wav", "kept": [[0, 1], [[1, 0, 0]]]}, "frames to keep"),
        ([1], "object"),
    ],
)
def test_odd_parameters_are_usage_errors(sturdy, params, said):
    sturdy.say({"id": 1, "method": "synthesize", "params": params})
    error = sturdy.hear("error")["error"]
    assert error["kind"] == "UsageError"
    assert said in error["message"]
    assert error["remedy"]


def test_unknown_method_lists_the_known(sturdy):
    sturdy.say({"id": "a", "method": "dance"})
    reply = sturdy.hear("error")
    assert reply["id"] == "a"
    assert "synthesize" in reply["error"]["remedy"]


def test_missing_output_folder_is_refused_before_any_work(sturdy, tmp_path):
    params = {"audio": "none.wav", "output_dir": str(tmp_path / "no")}
    sturdy.say({"id": 1, "method": "synthesize", "params": params})
    assert sturdy.hear("error")["error"]["kind"] == "OutputUnwritable"


def test_waiting_request_can_be_cancelled(worker):
    """All lines are in the pipe before the worker starts, so the cancellation overtakes the request."""
    many = [{"id": number, "method": "hello"} for number in range(300)]
    worker.say(*many, {"method": "cancel", "id": 299})
    kinds = {}
    for _ in range(300):
        message = worker.hear("id")
        kinds[message["id"]] = message.get("error", {}).get("kind")
    assert kinds[299] == "Cancelled"
    assert kinds[0] is None


def test_shutdown_and_end_of_file_end_it(worker):
    worker.say({"method": "shutdown"})
    assert worker.ended() == 0
    other = Pipe()
    other.process.stdin.close()
    assert other.ended() == 0


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
def test_dies_with_its_parent(tmp_path):
    code = (
        "import subprocess, sys, time\n"
        "p = subprocess.Popen([sys.executable, '-m', sys.argv[1]], cwd=sys.argv[2], stdin=-1, stdout=-1)\n"
        "print(p.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    arguments = [sys.executable, "-c", code, f"{ROOT.name}.core.worker.server", str(ROOT.parent)]
    parent = subprocess.Popen(arguments, stdout=subprocess.PIPE)
    child = int(parent.stdout.readline())
    os.kill(parent.pid, signal.SIGKILL)
    parent.communicate()
    for _ in range(500):
        status = Path(f"/proc/{child}/stat")
        if not status.exists() or status.read_text().split(")")[1].split()[0] == "Z":
            return
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    raise AssertionError("the worker outlived its parent")


@pytest.fixture(scope="module")
def busy(random_checkpoint):
    """One warm worker for the tests that synthesise."""
    pipe = Pipe()
    pipe.settings = {"checkpoint": str(random_checkpoint)}
    yield pipe
    pipe.process.kill()
    pipe.process.communicate()


@pytest.fixture(scope="module")
def long_voice(tmp_path_factory, examples):
    """Ten minutes of speech as a recording."""
    sound = audio_module().load(examples / "hello.flac")
    path = tmp_path_factory.mktemp("long") / "long.wav"
    samples = np.tile(sound, int(600 * 16000 / len(sound)))
    write_wav(path, samples)
    return path


def audio_module():
    pytest.importorskip("av", reason="the engine is not installed")
    from s2ag.core.sound import audio

    return audio


def test_synthesis_answers_with_motions_words_and_progress(busy, examples):
    params = {"audio": str(examples / "hello.flac"), "transcript": str(examples / "hello.txt"), "takes": 2, "seed": 3}
    wishes = {"style": {"calm one": 1.0}, "affect": {"arousal": 0.5}, "rate": -1, "hand": 0.25}
    busy.say({"id": 1, "method": "synthesize", "params": {**params, **busy.settings, **wishes}})
    stages = []
    while "event" in (message := busy.hear("id")):
        assert message["id"] == 1
        assert 0 <= message["value"] <= 1
        stages.append(message["stage"])
    result = message["result"]
    assert {"align words", "generate"} <= set(stages)
    first, second = (Motion.load(path) for path in result["motions"])
    assert first.directions.shape == second.directions.shape
    assert {name: first.meta[name] for name in wishes} == wishes
    assert [tuple(word) for word in result["words"]] == list(first.words)
    assert result["words"][0][0].lower() == "hello"
    assert result["seconds"] == pytest.approx(sum(result["stages"].values()), abs=1e-3)
    memory = Path(f"/proc/{busy.process.pid}/status")
    if memory.exists():
        (peak,) = (int(line.split()[1]) for line in memory.read_text().splitlines() if line.startswith("VmHWM"))
        assert peak < 700_000, f"{peak / 1000:.0f} MB"


def test_results_go_where_the_request_says(busy, examples, tmp_path):
    params = {"audio": str(examples / "hello.flac"), "output_dir": str(tmp_path), **busy.settings}
    busy.say({"id": 2, "method": "synthesize", "params": params})
    assert busy.hear()["result"]["motions"] == [str(tmp_path / "hello-1.npz")]
    assert [path.name for path in tmp_path.iterdir()] == ["hello-1.npz"]


@pytest.mark.parametrize("stage", ["align words", "generate"])
def test_synthesis_can_be_cancelled_while_it_runs(busy, examples, long_voice, stage, tmp_path):
    params = {"audio": str(long_voice), "text": "hello there " * 600, "output_dir": str(tmp_path), **busy.settings}
    if stage == "generate":
        del params["text"]
    busy.say({"id": stage, "method": "synthesize", "params": params})
    while (message := busy.hear("id")).get("stage") != stage:
        assert "event" in message
    busy.say({"method": "cancel", "id": stage})
    assert busy.hear("error")["error"]["kind"] == "Cancelled"
    assert not list(tmp_path.iterdir())
    busy.say({"id": 9, "method": "hello"})
    assert busy.hear()["id"] == 9


def test_errors_of_the_engine_have_kind_and_remedy(busy, tmp_path):
    busy.say({"id": 3, "method": "synthesize", "params": {"audio": str(tmp_path / "none.wav"), **busy.settings}})
    error = busy.hear("error")["error"]
    assert error["kind"] == "AudioUnreadable"
    assert "none.wav" in error["message"]
    assert error["remedy"]


def test_warm_hello_loads_the_network(random_checkpoint, worker):
    worker.say({"id": 1, "method": "hello", "params": {"warm": True, "checkpoint": str(random_checkpoint)}})
    result = worker.hear()["result"]
    assert [style["name"] for style in result["styles"]] == ["calm one", "lively one"]
    assert len(result["checkpoint"]["hash"]) == 64
    assert [control["name"] for control in result["controls"]] == ["arousal", "valence", "dominance", "rate", "hand"]
    maps = Path(f"/proc/{worker.process.pid}/maps")
    if maps.exists():
        assert "libtorch" in maps.read_text()


def test_shutdown_during_work_ends_it_and_removes_its_files(flow_checkpoint, long_voice, tmp_path):
    pipe = Pipe(env={**os.environ, "TMPDIR": str(tmp_path)})
    params = {"audio": str(long_voice), "checkpoint": str(flow_checkpoint)}
    pipe.say({"id": 1, "method": "synthesize", "params": params})
    while pipe.hear("event")["stage"] != "generate":
        pass
    pipe.say({"method": "shutdown"})
    assert pipe.ended() == 0
    pipe.process.communicate()
    assert not list(tmp_path.glob(f"{TEMPORARY_PREFIX}*"))


def test_a_vanished_temporary_folder_is_made_again_and_orphans_are_swept(flow_checkpoint, tmp_path):
    write_wav(tmp_path / "a.wav", np.zeros(8000))
    own = tmp_path / "temporary"
    own.mkdir()
    request = {"method": "synthesize", "params": {"audio": str(tmp_path / "a.wav"), "checkpoint": str(flow_checkpoint)}}
    killed = Pipe(env={**os.environ, "TMPDIR": str(own)})
    killed.say(request | {"id": 1})
    assert Path(killed.hear()["result"]["motions"][0]).is_file()
    killed.process.kill()
    killed.process.communicate()
    left = {path.name for path in own.glob(f"{TEMPORARY_PREFIX}*")}
    pipe = Pipe(env={**os.environ, "TMPDIR": str(own)})
    try:
        for number in range(3):
            pipe.say(request | {"id": number})
            assert Path(pipe.hear()["result"]["motions"][0]).is_file()
            assert left and not any((own / name).exists() for name in left)
            shutil.rmtree(own)
        pipe.process.stdin.close()
        assert pipe.ended() == 0
        assert not own.exists() or not list(own.glob(f"{TEMPORARY_PREFIX}*"))
    finally:
        pipe.process.kill()


def test_errors_cross_the_protocol_unchanged():
    error = errors.UnknownStyle("There is no style 'x'.", "Styles are: a, b.")
    back = protocol.to_exception(json.loads(protocol.encode(protocol.error_reply(7, error)))["error"])
    assert (type(back), back.message, back.remedy) == (errors.UnknownStyle, error.message, error.remedy)
    assert protocol.to_exception({"kind": "Internal", "message": "m"}).kind == "Internal"
    assert type(protocol.to_exception({"kind": "json", "message": "m"})) is errors.S2agError
    assert protocol.to_exception("nonsense").message


def test_edits_are_done_and_bad_ones_refused(worker, examples):
    params = {"audio": str(examples / "hello.flac"), "seed": 2}
    worker.say({"id": 1, "method": "synthesize", "params": {**params, "edits": []}})
    before = Motion.load(worker.hear()["result"]["motions"][0])
    edit = {"do": "reroll", "from": 3.0, "to": 5.0, "seed": 1}
    worker.say({"id": 2, "method": "synthesize", "params": {**params, "edits": [edit]}})
    after = Motion.load(worker.hear()["result"]["motions"][0])
    differ = np.flatnonzero((before.directions != after.directions).any((1, 2)))
    assert len(differ) and differ.min() >= 45 and differ.max() <= 76
    assert after.meta["edits"] == [edit]
    for number, wrong in enumerate(([{"do": "fly"}], {"do": "move"}, "delete"), 3):
        worker.say({"id": number, "method": "synthesize", "params": {**params, "edits": wrong}})
        assert worker.hear("error")["error"]["remedy"]
