"""The real worker process, spoken to over its pipes."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from s2ag.core import errors, protocol

ROOT = Path(__file__).parents[2]


class Pipe:
    """A worker and the two ends of its protocol."""

    def __init__(self, **options):
        command = [sys.executable, "-m", f"{ROOT.name}.core.worker"]
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


def test_hello_tells_version_and_loads_nothing_heavy(worker):
    worker.say({"id": 1, "method": "hello"})
    result = worker.hear()["result"]
    assert result["protocol"] == protocol.VERSION
    assert result["version"].count(".") == 2
    assert isinstance(result["styles"], list)
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
def test_garbage_is_answered_and_survived(worker, line):
    worker.say(line, {"id": 2, "method": "hello"})
    refusal = worker.hear("error")
    assert refusal["id"] is None
    assert refusal["error"]["kind"] == "BadRequest"
    assert worker.hear()["id"] == 2


def test_empty_lines_are_no_requests(worker):
    worker.say(b"\n \n", {"id": 5, "method": "hello"})
    assert worker.hear("id")["id"] == 5


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({}, "no audio"),
        ({"audio": 3}, "audio"),
        ({"audio": "a.wav", "seed": "x"}, "seed"),
        ({"audio": "a.wav", "seed": True}, "seed"),
        ({"audio": "a.wav", "speed": 2}, "speed"),
        ({"audio": "a.wav", "takes": 0}, "takes"),
        ({"audio": "a.wav", "text": "a", "transcript": "b"}, "transcript"),
        ([1], "object"),
    ],
)
def test_odd_parameters_are_usage_errors(worker, params, said):
    worker.say({"id": 1, "method": "synthesize", "params": params})
    error = worker.hear("error")["error"]
    assert error["kind"] == "UsageError"
    assert said in error["message"]
    assert error["remedy"]


def test_unknown_method_lists_the_known(worker):
    worker.say({"id": "a", "method": "dance"})
    reply = worker.hear("error")
    assert reply["id"] == "a"
    assert "synthesize" in reply["error"]["remedy"]


def test_missing_output_folder_is_refused_before_any_work(worker, tmp_path):
    params = {"audio": "none.wav", "output_dir": str(tmp_path / "no")}
    worker.say({"id": 1, "method": "synthesize", "params": params})
    assert worker.hear("error")["error"]["kind"] == "OutputUnwritable"


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
    arguments = [sys.executable, "-c", code, f"{ROOT.name}.core.worker", str(ROOT.parent)]
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


def test_errors_cross_the_protocol_unchanged():
    error = errors.UnknownStyle("There is no style 'x'.", "Styles are: a, b.")
    back = protocol.revive(json.loads(protocol.encode(protocol.failure(7, error)))["error"])
    assert (type(back), back.message, back.remedy) == (errors.UnknownStyle, error.message, error.remedy)
    assert protocol.revive({"kind": "Internal", "message": "m"}).kind == "Internal"
    assert type(protocol.revive({"kind": "json", "message": "m"})) is errors.S2agError
    assert protocol.revive("nonsense").message
