"""The check of a Python: with real packages it passes, with odd ones one sentence says what is wrong and what to do."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from s2ag.core.errors import Cancelled, EngineMissing, S2agError, WorkerFailed
from s2ag.core.version import VERSION
from s2ag.core.worker import interpreter


def printed(folder: Path) -> list[str]:
    """What the check of the package in this Python prints, which finds the modules in ``folder`` first."""
    places = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        interpreter.command(sys.executable), capture_output=True, text=True, env={**os.environ, "PYTHONPATH": places}
    )
    return done.stdout.splitlines()


def facts(**others) -> list[str]:
    """What the check prints for a Python that works, but for ``others``."""
    return [json.dumps({"s2ag": VERSION, "problem": "", "packages": {"torch": "2.4"}, **others})]


def python_with(folder: Path, package: str | None) -> str:
    """A Python that has nothing but a package ``s2ag`` with this source in its ``__init__.py``; None: not even that."""
    subprocess.run([sys.executable, "-I", "-m", "venv", "--without-pip", str(folder)], check=True)
    if package is not None:
        (place,) = [folder / "Lib" / "site-packages"] if os.name == "nt" else folder.glob("lib/python*/site-packages")
        (place / "s2ag").mkdir()
        (place / "s2ag" / "__init__.py").write_text(package)
    return interpreter.find_python(folder)


@pytest.fixture
def alone(monkeypatch, tmp_path):
    """The working folder holds a stray folder ``s2ag``, and no variable leads to the package."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    (tmp_path / "s2ag").mkdir()
    (tmp_path / "s2ag" / "__init__.py").write_text(f"__version__ = {VERSION!r}\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "python"


@pytest.mark.slow
def test_a_clip_is_decoded_and_gestured():
    pytest.importorskip("av")
    pytest.importorskip("torch")
    told = interpreter.Check(sys.executable).wait()
    assert told["gestured"] == pytest.approx(14.7, abs=0.1) and not told["problem"]


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
sys.argv = ["start", "--", "core.worker.inventory", "--try"]
runpy.run_path({interpreter.command(None)[2]!r}, run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    told = interpreter.read_facts(done.stdout.splitlines())
    assert told["gestured"] == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize(
    ("lines", "error", "sentence"),
    [
        (facts(packages={"torch": ""}), EngineMissing, "This Python has no PyTorch"),
        (facts(problem="torch does not load: x"), WorkerFailed, "does not work: torch does not load: x"),
        (facts(s2ag="0.0.1", problem="x"), EngineMissing, f"has version 0.0.1 of the package s2ag instead of {VERSION}"),
        (["python: ... (ModuleNotFoundError: No module named 's2ag')"], EngineMissing, "does not have the package s2ag"),
        (["python: No module named s2ag.core.worker.inventory"], EngineMissing, "another version of the package s2ag"),
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


@pytest.mark.parametrize(
    ("package", "sentence"),
    [
        (None, "This Python does not have the package s2ag"),
        ("__version__ = '0.0.1'\n", "version 0.0.1 of the package s2ag instead|another version of the package s2ag"),
        ("1 / 0\n", "cannot run the engine: ZeroDivisionError"),
    ],
)
def test_the_package_of_a_python_counts_and_no_folder_beside_it(alone, package, sentence):
    python = python_with(alone, package)
    for check in (interpreter.require_package, lambda python: interpreter.Check(python).wait()):
        with pytest.raises(S2agError, match=sentence) as raised:
            check(python)
        assert "pip install" in raised.value.remedy


def test_a_package_of_this_version_is_accepted(alone):
    interpreter.require_package(python_with(alone, f"__version__ = {VERSION!r}\n"))


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
        interpreter.find_python(tmp_path)
    python.parent.mkdir()
    python.touch()
    assert interpreter.find_python(tmp_path) == str(python) and interpreter.find_python("python3") == "python3"
