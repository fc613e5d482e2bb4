"""The check of a Python: with real packages it passes, with odd ones one sentence says what is wrong and what to do."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from s2ag.core.engine import interpreter
from s2ag.core.errors import Cancelled, EngineMissing, WorkerFailed


def printed(folder: Path | None = None) -> list[str]:
    """What the check prints in this Python, which finds the modules in ``folder`` first."""
    python, _, *rest = interpreter.command(sys.executable)
    variables = {**os.environ, "PYTHONPATH": str(folder or "")}  # -I would not see it
    return subprocess.run([python, "-P", *rest], capture_output=True, text=True, env=variables).stdout.splitlines()


@pytest.mark.slow
def test_a_clip_is_decoded_and_gestured():
    pytest.importorskip("av")
    pytest.importorskip("torch")
    facts = interpreter.Check(sys.executable, full=True).wait()
    assert facts["gestured"] == pytest.approx(14.7, abs=0.1) and not facts["problem"]


def test_an_engine_that_imports_but_cannot_decode_does_not_pass(tmp_path):
    """As av 19 was, which had no argument of ours any more."""
    (tmp_path / "av").mkdir()
    (tmp_path / "av" / "__init__.py").write_text("def open(file):\n    return file\n")
    (tmp_path / "av" / "error.py").write_text("FFmpegError = ValueError\n")
    with pytest.raises(WorkerFailed, match="The engine does not work: a clip is not gestured .TypeError"):
        interpreter.read_facts(printed(tmp_path))


def test_without_a_decoder_it_gestures_what_blender_would_hand_over():
    """Blender's own Python has numpy alone."""
    code = f"""
import importlib.util, runpy, sys
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name in ("av", "torch") else found(name, *rest)
sys.argv = ["start", "--", "core.engine.inventory", "--try"]
runpy.run_path({interpreter.command(sys.executable)[2]!r}, run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    facts = interpreter.read_facts(done.stdout.splitlines())
    assert facts["gestured"] == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize(
    ("lines", "error", "sentence"),
    [
        ([json.dumps({"problem": "", "packages": {"torch": ""}})], EngineMissing, "This Python has no PyTorch"),
        ([json.dumps({"problem": "torch does not load: x"})], WorkerFailed, "does not work: torch does not load: x"),
        (["Unknown option: -P", "usage: python3.9"], WorkerFailed, "older than 3.11"),
        (["Traceback", "ModuleNotFoundError: No module named 'numpy'"], WorkerFailed, "cannot run the engine: ModuleNotFound"),
        (["{broken"], WorkerFailed, "cannot run the engine"),
        ([], WorkerFailed, "it said nothing"),
    ],
)
def test_what_is_wrong_is_one_sentence_with_its_remedy(lines, error, sentence):
    with pytest.raises(error, match=sentence) as raised:
        interpreter.read_facts(lines, full=True)
    assert raised.value.remedy


def test_a_check_that_is_cancelled_ends_its_process(monkeypatch):
    monkeypatch.setattr(interpreter, "command", lambda python: [python, "-c", "import time; time.sleep(600)"])
    check = interpreter.Check(sys.executable)
    assert not check.poll()
    check.cancel()
    assert check.done and isinstance(check.error, Cancelled) and check._process.returncode is not None
    with pytest.raises(Cancelled):
        check.wait()


def test_pythons_in_folders(tmp_path):
    python = tmp_path / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    with pytest.raises(EngineMissing, match="There is no Python in"):
        interpreter.python_in(tmp_path)
    python.parent.mkdir()
    python.touch()
    assert interpreter.python_in(tmp_path) == str(python) and interpreter.python_in("python3") == "python3"
