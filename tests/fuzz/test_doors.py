"""Thousands of damaged inputs at every door: each ends in a result or in two sentences, soon and within bounded memory.

``S2AG_FUZZ=50000 pytest tests/fuzz`` tries as many instead of the few hundred of every run; ``S2AG_FUZZ_FIRST`` is the number
of the first, so that every night can try others. ``python tests/fuzz/serve.py DOOR NUMBER 1`` tries one again.
"""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import doors
import pytest
from s2ag.core.errors import S2agError

if importlib.util.find_spec("torch"):
    import networks  # noqa: F401 (its doors are listed with the others)
    import torch  # noqa: F401 (takes seconds, which no test has to spare)

pytest.importorskip("praatio", reason="the engine is not installed")
pytest.importorskip("av", reason="the engine is not installed")
pytest.importorskip("webvtt", reason="good subtitles are written by it")
if sys.platform != "linux":
    pytest.skip("memory is limited and measured as Linux does", allow_module_level=True)

COUNT, FIRST = int(os.environ.get("S2AG_FUZZ", "800")), int(os.environ.get("S2AG_FUZZ_FIRST", "0"))
SHARES = {"transcript": 6, "wave": 3, "film": 3, "manifest": 2, "pickle": 3, "performance": 2, "motion": 2}
"""Where damage has the most ways."""


class Server:
    """The process that tries inputs, started again where one has ended it."""

    def __init__(self):
        self._process = None

    def ask(self, door: str, first: int, count: int) -> tuple[list[dict], dict]:
        """What fell of these inputs, and the last line of the door."""
        if self._process is None or self._process.poll() is not None:
            paths = [Path(__file__).parent, *sys.path]
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths)), "OMP_NUM_THREADS": "1"}
            command = [sys.executable, str(Path(__file__).with_name("serve.py"))]
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
            self._process = subprocess.Popen(command, **pipes, text=True, env=environment)
        self._process.stdin.write(f"{door} {first} {count}\n")
        self._process.stdin.flush()
        fallen = []
        for line in self._process.stdout:
            message = json.loads(line)
            if "done" in message:
                return fallen, message
            fallen.append(message)
        return fallen, {"ended": self._process.wait(), "door": door, "first": first, "count": count}

    def close(self):
        if self._process is not None:
            self._process.stdin.close()
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()


@pytest.fixture(scope="module")
def server():
    """One process for all doors: what they share is loaded once."""
    made = Server()
    yield made
    made.close()


READ_HERE = {"protocol", "serialised"}
"""Doors whose bytes this harness reads and passes on."""
WITHOUT = {"record", "cache", "table", "acoustic", "challenge", "corpus"}
"""Doors where what cannot be read may count as nothing."""


@pytest.mark.timeout(30)  # they end at once; a pipe that is waited for would cost all the time that a test may take
@pytest.mark.parametrize("kind", ["pipe", "loop", "folder", "nothing"])
@pytest.mark.parametrize("door", sorted(doors.DOORS.keys() - READ_HERE))
def test_what_is_no_file_ends_in_two_sentences(door, kind, tmp_path):
    """Nothing ever comes from a pipe that nobody writes to."""
    for suffix in {suffix for suffix, _ in doors.DOORS[door].seeds()}:
        path = tmp_path / f"input{suffix}"
        {"pipe": os.mkfifo, "loop": lambda path: path.symlink_to(path), "folder": os.mkdir}.get(kind, bool)(path)
        try:
            doors.DOORS[door].use(path)
            assert door in WITHOUT, suffix
        except S2agError as error:
            assert error.message and error.remedy


@pytest.mark.timeout(0 if COUNT > 5000 else 300)
@pytest.mark.parametrize("door", doors.DOORS)
def test_damaged_inputs_end_in_results_or_sentences(server, door):
    every = sum(SHARES.get(name, 1) for name in doors.DOORS)
    count = max(COUNT * SHARES.get(door, 1) // every, 1)
    fallen, last = server.ask(door, FIRST, count)
    print(last)
    assert not fallen, f"{len(fallen)} fell, the first: {json.dumps(fallen[0], indent=1)}"
    assert last.get("tried") == count, last
