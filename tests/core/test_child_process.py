"""A child that is started before it is asked."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from s2ag.core import child_process

ECHO = [sys.executable, "-c", "import os, sys; line = sys.stdin.readline(); print(line and f'[{os.getpid()}]', flush=True)"]
"""Answers any request with its own number, and ends where none comes."""


@pytest.fixture
def reserve():
    found = child_process.StandbyChild()
    yield found
    waiting = found.take(ECHO)
    waiting.communicate(b"")


def asked(reserve: child_process.StandbyChild | None, command: list[str] = ECHO) -> int:
    return child_process.run_request(command, {}, [], 20.0, lambda answer: answer[0], reserve)


def waiting(reserve: child_process.StandbyChild) -> subprocess.Popen:
    reserve.start(ECHO)
    return reserve._child


def test_the_child_that_waits_is_asked_once(reserve):
    first = waiting(reserve)
    reserve.start(ECHO)
    assert asked(reserve) == first.pid
    assert asked(reserve) not in (first.pid, os.getpid())


def test_without_a_reserve_a_child_of_its_own_is_asked():
    assert asked(None) != asked(None)


def test_a_child_that_died_waiting_is_replaced(reserve):
    first = waiting(reserve)
    first.kill()
    first.wait()
    assert asked(reserve) != first.pid


def test_a_child_of_another_command_is_ended_and_not_asked(reserve):
    first = waiting(reserve)
    assert asked(reserve, [*ECHO, "other"]) != first.pid
    assert first.poll() is not None


def test_what_cannot_be_started_is_missed_when_it_is_asked(tmp_path):
    reserve, command = child_process.StandbyChild(), [str(tmp_path / "nothing")]
    reserve.start(command)
    with pytest.raises(child_process.ChildFailed, match="could not be started"):
        asked(reserve, command)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks for processes in /proc")
def test_an_aligner_that_waits_ends_with_its_worker(tmp_path):
    """However that ends: nobody would ask it any more."""
    program = (
        "import os; from s2ag.core.words import align; align.start_child(); print(align._RESERVE._child.pid, flush=True); "
    )
    done = subprocess.run([sys.executable, "-c", program + "os._exit(1)"], stdout=subprocess.PIPE, text=True)
    end = time.monotonic() + 30
    while Path(f"/proc/{int(done.stdout)}").exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not Path(f"/proc/{int(done.stdout)}").exists()
