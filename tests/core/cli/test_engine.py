"""``s2ag engine``: what it says before it works, and in which Python."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import wheels
from s2ag.core.cli.main import main
from s2ag.core.setup import planning
from s2ag.core.start import module_command

needs_venv = pytest.mark.skipif(
    not planning.PYTHONS[0] <= sys.version_info[:2] < planning.PYTHONS[1], reason="this Python is not for the engine"
)


@needs_venv
def test_sizes_and_commands_are_said_before_anything_is_made(capsys, tmp_path):
    assert main(["engine", "setup", str(tmp_path / "engine"), "--show"]) == 0
    said = capsys.readouterr().out
    assert "takes about 1.3 GB" in said and "-m venv" in said and "--only-binary :all:" in said and "faster-whisper" not in said
    assert main(["engine", "setup", str(tmp_path / "engine"), "--show", "--recognise"]) == 0
    assert "faster-whisper" in capsys.readouterr().out and not (tmp_path / "engine").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["setup", "engine", "--wheels", "nothing"], "no folder of wheels"),
        (["setup", "engine", "--python", "nothing"], "nothing cannot be run"),
        (["check", "."], "No engine is in"),
    ],
)
def test_what_cannot_be_is_one_sentence(capsys, tmp_path, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    assert main(["engine", *arguments]) == 2
    said = capsys.readouterr().err
    assert told in said and said.count("\n") == 1


def test_it_runs_in_a_python_without_numpy():
    """As the panel's command does, by the path of a file."""
    command = module_command(sys.executable, "core.cli.engine_alone")
    code = f"import sys, runpy; sys.modules['numpy'] = None; sys.argv = {command[2:]!r} + ['check', 'nowhere']; "
    done = subprocess.run(
        [sys.executable, "-c", code + f"runpy.run_path({command[2]!r}, run_name='__main__')"], capture_output=True, text=True
    )
    assert done.returncode == 2 and "nowhere cannot be run" in done.stderr


@needs_venv
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="processes are looked at as Linux shows them")
def test_a_set_up_that_is_ended_leaves_neither_processes_nor_files(tmp_path):
    """As the panel's command starts it, and as a system ends it."""
    packages, folder = wheels.write_wheels(tmp_path / "wheels", size=200_000_000), tmp_path / "engine"
    command = [*module_command(sys.executable, "core.cli.engine_alone"), "setup", str(folder), "--wheels", str(packages)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while len(working(folder)) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(working(folder)) > 1, "what makes the environment, beside the command"
    process.send_signal(signal.SIGTERM)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130 and said.endswith("interrupted.\n")
    while working(folder) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not working(folder) and [path.name for path in folder.iterdir()] == ["logs"]


def working(folder: Path) -> list[str]:
    """Numbers of the processes whose command names a folder."""
    found = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(folder) in place.read_bytes().decode("utf-8", "replace"):
                found.append(place.parent.name)
        except OSError:  # it has just ended
            continue
    return found
