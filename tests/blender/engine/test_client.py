"""The client against the real worker, and against workers that die, hang or talk nonsense."""

import os
import signal
import subprocess
import sys
import time
import wave

import numpy as np
import pytest
from s2ag.core.errors import Cancelled, EngineMissing, S2agError, UsageError, WorkerFailed
from s2ag.core.motion.motion import Motion
from s2ag.core.worker import interpreter
from s2ag.s2ag_blender.engine import client as module
from s2ag.s2ag_blender.engine.client import WorkerClient

HELLO = """import json
for line in open(0):
    m = json.loads(line)
    print(json.dumps({"id": m.get("id"), "result": m}), flush=True)
"""


@pytest.fixture
def start(tmp_path):
    """Makes clients of fake workers (a Python script each) that are closed at the end."""
    clients = []

    def make(script, **options):
        path = tmp_path / f"fake{len(clients)}.py"
        path.write_text(script)
        clients.append(WorkerClient(command=[sys.executable, str(path)], **options))
        return clients[-1]

    yield make
    for one in clients:
        one.close()


def wait(job, seconds=120.0):
    end = time.monotonic() + seconds
    while not job.poll():
        assert time.monotonic() < end, "no answer"
        time.sleep(0.01)
    return job


@pytest.fixture
def tone(tmp_path):
    """Two seconds that any engine can read."""
    path = tmp_path / "tone.wav"
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
        file.writeframes((8000 * np.sin(np.arange(32000) / 20)).astype("<i2").tobytes())
    return path


@pytest.fixture(scope="module")
def real():
    """A client of the real worker; its interpreter needs nothing for ``hello``."""
    with WorkerClient(python=os.environ.get("S2AG_PYTHON") or sys.executable) as client:
        yield client


def test_real_worker_answers(real):
    assert real.call("hello")["protocol"] == 1
    with pytest.raises(UsageError, match="no audio"):
        real.call("synthesize", {})


def test_real_worker_restarts_after_a_kill(real):
    real.call("hello")
    first = real.pid
    job = real.request("hello")
    os.kill(first, signal.SIGKILL)
    time.sleep(0.2)
    wait(job)
    assert real.call("hello")["protocol"] == 1
    assert real.pid != first


@pytest.mark.slow
def test_real_worker_killed_in_mid_synthesis(random_checkpoint, examples):
    params = {"audio": str(examples / "hello.flac"), "checkpoint": str(random_checkpoint)}
    with WorkerClient() as client:
        job = client.request("synthesize", params)
        while not job.stage:
            assert not job.poll()
        os.kill(client.pid, signal.SIGKILL)
        with pytest.raises(WorkerFailed, match="killed by signal 9"):
            wait(job).outcome()
        heard = []
        result = client.call("synthesize", params, progress=lambda *said: heard.append(said))
        assert [os.path.exists(path) for path in result["motions"]] == [True]
        assert heard
    assert not os.path.exists(result["motions"][0])


def test_killed_in_mid_job_says_so_and_the_next_request_works(start):
    client = start(
        "import os, json\n"
        "first = not os.path.exists(__file__ + '.again'); open(__file__ + '.again', 'w').close()\n"
        "for line in open(0):\n"
        "    m = json.loads(line)\n"
        "    if first: print(json.dumps({'id': m['id'], 'event': 'progress', 'stage': 'align', 'value': 0.5}), flush=True)\n"
        "    else: print(json.dumps({'id': m['id'], 'result': {}}), flush=True)\n"
    )
    job = client.request("synthesize")
    while not job.stage:
        assert not job.poll()
    assert (job.stage, job.value) == ("align", 0.5)
    os.kill(client.pid, signal.SIGKILL)
    with pytest.raises(WorkerFailed, match="killed by signal 9") as caught:
        wait(job).outcome()
    assert caught.value.remedy
    assert client.call("hello") == {}


NONSENSE = ["hello there", "[1]", '{"id": 1}', '{"id": 1, "result": 5}', '{"id": 1, "event": "progress", "value": "x"}']


@pytest.mark.parametrize("line", NONSENSE)
def test_nonsense_is_one_clear_error(start, line):
    client = start(f"input()\nprint({line!r}, flush=True)\nimport time; time.sleep(60)\n")
    with pytest.raises(WorkerFailed, match="nonsense"):
        client.call("hello")


def test_hung_worker_is_given_up(start):
    client = start("import time\ntime.sleep(60)\n")
    with pytest.raises(WorkerFailed, match="not said a word"):
        client.call("hello", timeout=0.3)
    assert client.pid is None


def test_large_request_to_a_hung_worker_does_not_block(start):
    client = start("import time\ntime.sleep(60)\n", patience=0.3)
    began = time.monotonic()
    job = client.request("synthesize", {"text": "word " * 200_000})
    assert not job.done
    with pytest.raises(WorkerFailed):
        wait(job).outcome()
    assert time.monotonic() - began < 30


def test_worker_that_ends_at_once_gives_status_and_advice(start):
    client = start("import a_package_that_is_not_there\n")
    with pytest.raises(WorkerFailed, match="ended with status 1") as caught:
        client.call("hello")
    assert "a_package_that_is_not_there" in caught.value.remedy


def test_cancel_is_passed_on(start):
    client = start(
        "import json\n"
        "for m in map(json.loads, open(0)):\n"
        "    if m['method'] == 'cancel':\n"
        "        e = {'kind': 'Cancelled', 'message': 'Cancelled.', 'remedy': ''}\n"
        "        print(json.dumps({'id': m['id'], 'error': e}), flush=True)\n"
    )
    job = client.request("synthesize")
    client.cancel(job)
    client.cancel(job)
    with pytest.raises(Cancelled):
        wait(job).outcome()
    assert client.pid is not None


def test_worker_deaf_to_cancellation_is_killed(start, monkeypatch):
    monkeypatch.setattr(module, "GRACE", 0.2)
    client = start(
        "import os, json, time\n"
        "if not os.path.exists(__file__ + '.again'): open(__file__ + '.again', 'w').close(); time.sleep(60)\n"
        "for m in map(json.loads, open(0)): print(json.dumps({'id': m['id'], 'result': {}}), flush=True)\n"
    )
    job = client.request("synthesize")
    time.sleep(0.5)
    client.cancel(job)
    other = client.request("synthesize")
    with pytest.raises(Cancelled):
        wait(job).outcome()
    assert wait(other).outcome() == {}, "the next press fails for the one before"


def test_what_waits_behind_another_is_cancelled_at_once_and_leaves_the_other(start, monkeypatch):
    """A draft that is no longer wanted while 24 takes are made: the worker reads of it when they are done."""
    monkeypatch.setattr(module, "GRACE", 0.05)
    client = start(
        "import json, sys, time\n"
        "first, second = (json.loads(sys.stdin.readline())['id'] for _ in range(2))\n"
        "print(json.dumps({'id': first, 'event': 'progress', 'stage': 'draw', 'value': 0.5}), flush=True)\n"
        "time.sleep(0.5)\n"
        "print(json.dumps({'id': first, 'result': {'takes': 24}}), flush=True)\n"
        "e = {'kind': 'Cancelled', 'message': 'Cancelled.', 'remedy': ''}\n"
        "print(json.dumps({'id': second, 'error': e}), flush=True)\n"
        "sys.stdin.read()\n"
    )
    long, queued = client.request("synthesize"), client.request("synthesize")
    client.cancel(queued)
    assert queued.done and not long.done
    with pytest.raises(Cancelled):
        queued.outcome()
    assert wait(long).outcome() == {"takes": 24}
    client.pump()
    assert client.pid is not None


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
def test_interrupt_cancels_and_is_passed_on(start, monkeypatch, interruptible):
    monkeypatch.setattr(module, "GRACE", 0.2)
    client = start("import os, signal, time\nos.kill(os.getppid(), signal.SIGINT)\ntime.sleep(60)\n")
    with pytest.raises(KeyboardInterrupt):
        client.call("synthesize")
    assert client.pid is None


def test_progress_log_and_unknown_errors(start):
    client = start(
        "import json, sys\n"
        "i = json.loads(input())['id']\n"
        "print('a log line', file=sys.stderr, flush=True)\n"
        "for v in (0.0, 0.5):\n"
        "    print(json.dumps({'id': i, 'event': 'progress', 'stage': 's', 'value': v}), flush=True)\n"
        "print(json.dumps({'id': i, 'error': {'kind': 'New', 'message': 'M.', 'remedy': 'R.'}}), flush=True)\n"
        "input()\n",
        log=(lines := []).append,
    )
    heard = []
    with pytest.raises(S2agError) as caught:
        client.call("synthesize", progress=lambda *said: heard.append(said))
    assert (caught.value.kind, str(caught.value)) == ("New", "M. R.")
    assert heard in ([], [("s", 0.0)], [("s", 0.5)], [("s", 0.0), ("s", 0.5)])
    while not lines:
        client.pump()
    assert lines == ["a log line"]


def test_close_ends_jobs_and_process(start):
    client = start(HELLO)
    assert client.call("hello")["method"] == "hello"
    pid = client.pid
    job = client.request("hello")
    client.close()
    with pytest.raises(Cancelled):
        job.outcome()
    if os.name != "nt":
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


@pytest.fixture
def no_python(monkeypatch, tmp_path):
    """Nothing that may be started: this Python's name is that of a file that is not there."""
    monkeypatch.delenv("S2AG_PYTHON", raising=False)
    monkeypatch.setattr(module.sys, "executable", str(tmp_path / "python3"))


def test_a_thread_takes_over_where_no_python_can_be_started(no_python, tone):
    lines = []
    with WorkerClient(log=lines.append) as client:
        assert client.call("hello")["protocol"] == 1 and client.pid is None
        assert "thread of Blender's own process" in lines[0]
        with pytest.raises(UsageError, match="no audio"):
            client.call("synthesize", {})
        (path,) = client.call("synthesize", {"audio": str(tone)})["motions"]
        assert Motion.load(path).duration > 1
    end = time.monotonic() + 60
    while os.path.exists(path):  # its folder goes with it
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_thread_drops_what_is_cancelled_and_serves_on(no_python, tone):
    with WorkerClient() as client:
        job = client.request("synthesize", {"audio": str(tone), "takes": 64})
        client.cancel(job)
        with pytest.raises(Cancelled):
            wait(job, 120).outcome()
        assert client.call("hello")["protocol"] == 1


def test_a_python_that_was_named_is_not_replaced_by_a_thread(tmp_path):
    with pytest.raises(WorkerFailed, match="cannot be run"):
        WorkerClient(python=tmp_path / "python3").call("hello")


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX")
def test_a_package_of_another_version_is_refused_before_it_is_used(tmp_path, tone):
    python = tmp_path / "python"
    older = "import sys, s2ag.core.worker.server as worker\nworker.VERSION = '0.0.1'\nsys.exit(worker.main())\n"
    (tmp_path / "older.py").write_text(older)
    python.write_text(f"#!/bin/sh\nexec {sys.executable} {tmp_path / 'older.py'}\n")
    python.chmod(0o755)
    with WorkerClient(python=python) as client:
        for _ in range(2):  # a new process each time
            with pytest.raises(EngineMissing, match="version 0.0.1 of the package s2ag instead") as raised:
                client.call("synthesize", {"audio": str(tone)})
            assert "pip install --upgrade" in raised.value.remedy and client.pid is None


def test_a_python_without_the_package_is_one_sentence(monkeypatch, tmp_path):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    subprocess.run([sys.executable, "-I", "-m", "venv", "--without-pip", str(tmp_path / "bare")], check=True)
    wanted = pytest.raises(EngineMissing, match="does not have the package s2ag.*pip install")
    with WorkerClient(python=interpreter.find_python(tmp_path / "bare")) as client, wanted:
        client.call("hello")


def test_the_thread_brings_nothing_heavy_into_blender(tmp_path):
    code = (
        "import sys\n"
        "sys.executable = sys.argv[1]\n"
        "from s2ag.s2ag_blender.engine.client import WorkerClient\n"
        "with WorkerClient() as client:\n"
        "    client.call('hello', {'warm': True})\n"
        "print(*{name.split('.')[0] for name in sys.modules})\n"
    )
    clean = {name: value for name, value in os.environ.items() if name != "S2AG_PYTHON"}
    command = [sys.executable, "-c", code, tmp_path / "python3"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=clean)
    assert not {"torch", "scipy", "librosa", "av", "gensim"} & set(done.stdout.split())


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="looks for processes in /proc")
def test_an_aligner_waits_for_the_next_words_and_ends_with_the_worker(tone):
    def children(pid):
        with open(f"/proc/{pid}/task/{pid}/children") as file:
            return file.read().split()

    with WorkerClient() as client:
        client.call("synthesize", {"audio": str(tone)})
        assert not children(client.pid)  # nobody spoke of words
        client.call("synthesize", {"audio": str(tone), "text": "Hello there."})
        end = time.monotonic() + 5
        while not (waiting := children(client.pid)) and time.monotonic() < end:
            time.sleep(0.01)
        assert len(waiting) == 1
    end = time.monotonic() + 30
    while os.path.exists(f"/proc/{waiting[0]}") and time.monotonic() < end:
        time.sleep(0.05)
    assert not os.path.exists(f"/proc/{waiting[0]}")
