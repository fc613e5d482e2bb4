"""The engine's self-test decodes and gestures a clip: with real packages it passes, with an odd one it says what is wrong."""

import _thread
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import wheels
from s2ag.core.setup import making, planning, trial
from s2ag.core.setup.environment import SetupFailed, environment

needs_venv = pytest.mark.skipif(
    not planning.PYTHONS[0] <= sys.version_info[:2] < planning.PYTHONS[1], reason="this Python is not for the engine"
)


def tried(folder: Path | None = None) -> list[str]:
    """What the trial prints in this Python, which finds the modules in ``folder`` first."""
    python, _, *rest = trial.command(sys.executable)
    variables = {**os.environ, "PYTHONPATH": str(folder or "")}  # -I would not see it
    return subprocess.run([python, "-P", *rest], capture_output=True, text=True, env=variables).stdout.splitlines()


@pytest.mark.slow
def test_a_clip_is_decoded_and_gestured():
    pytest.importorskip("av")
    pytest.importorskip("torch")
    facts = trial.read_facts(tried())
    assert facts["gestured"] == pytest.approx(14.7, abs=0.1) and not facts["problem"]


def test_an_engine_that_imports_but_cannot_decode_does_not_pass(tmp_path):
    """As av 19 was, which had no argument of ours any more."""
    (tmp_path / "av.py").write_text("FFmpegError = ValueError\ndef open(file):\n    return file\n")
    with pytest.raises(SetupFailed, match="The engine does not work: a clip is not gestured .TypeError"):
        trial.read_facts(tried(tmp_path))


def test_without_a_decoder_it_gestures_what_blender_would_hand_over():
    """Blender's own Python has numpy alone."""
    code = f"""
import importlib.util, runpy, sys
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name in ("av", "torch") else found(name, *rest)
sys.argv = ["start", "--", "core.engine.inventory", "--try"]
runpy.run_path({trial.command(sys.executable)[2]!r}, run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    facts = trial.read_facts(done.stdout.splitlines())
    assert facts["gestured"] == pytest.approx(5.0, abs=0.1)


@pytest.mark.slow
@needs_venv
def test_the_set_up_gestures_before_it_takes_over(tmp_path):
    """Wheels that lead to the packages of this Python: the environment finds the real ones."""
    pytest.importorskip("torch")
    av = pytest.importorskip("av")
    folder = wheels.write_wheels(tmp_path / "wheels", linked=Path(av.__file__).parents[1])
    facts = making.Setup(planning.plan(tmp_path / "user", wheels=str(folder))).wait()
    assert facts["gestured"] > 14 and environment(tmp_path / "user") is not None


FOREVER = "import time; time.sleep(600)"


@pytest.fixture
def interrupted(monkeypatch):
    """Lets a signal come while a process is being started; returns the processes that were."""
    started, popen = [], subprocess.Popen

    def start(*command, **options):
        _thread.interrupt_main()
        time.sleep(0.2)
        started.append(popen(*command, **options))
        time.sleep(0.2)
        return started[-1]

    monkeypatch.setattr(trial.subprocess, "Popen", start)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    yield started
    signal.signal(signal.SIGINT, before)


def test_a_signal_that_comes_while_a_program_is_started_leaves_none(interrupted):
    program = trial.Program([sys.executable, "-c", FOREVER])
    with pytest.raises(KeyboardInterrupt):
        program.start()
    program.kill()
    program._reader.join(10)
    assert [one.wait(10) for one in interrupted] and len(interrupted) == 1  # its pipe is closed before it has ended
    assert program.done()


def test_a_program_that_was_killed_before_it_began_never_begins(tmp_path):
    program = trial.Program([sys.executable, "-c", f"open({str(tmp_path / 'ran')!r}, 'w')"])
    program.kill()
    program.start()
    program._reader.join(10)
    assert not program._reader.is_alive() and not (tmp_path / "ran").exists()


def test_a_signal_that_comes_while_a_check_starts_leaves_no_process(interrupted, monkeypatch):
    monkeypatch.setattr(trial, "command", lambda python: [str(python), "-c", FOREVER])
    with pytest.raises(KeyboardInterrupt):
        trial.Check(sys.executable)
    assert [one.wait(10) for one in interrupted]  # killed, so it has ended and not well
