"""``blender --command s2ag``: the function that Blender calls, in a process of its own as in Blender."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import wheels
from s2ag.core.errors import WorkerFailed
from s2ag.s2ag_blender.engine import client, setup

START = (
    "import sys, bpy, s2ag\n"
    "s2ag.register()\n"
    "from s2ag.s2ag_blender.ui import command\n"
    "code = command.main(sys.argv[1:])\n"
    "assert 'torch' not in sys.modules\n"
    "s2ag.unregister()\n"
    "sys.exit(code)\n"
)


@pytest.fixture
def command(tmp_path):
    """Runs the command with a fresh home of Blender and returns the finished process."""

    def run(*arguments, **variables):
        home = {"BLENDER_USER_RESOURCES": str(tmp_path / "home"), **variables}
        return subprocess.run(
            [sys.executable, "-c", START, *map(str, arguments)],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env={name: value for name, value in {**os.environ, **home}.items() if value is not None},
        )

    return run


@pytest.fixture
def engine():
    try:
        return client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))


def test_animate_writes_what_the_command_line_writes(command, engine, examples, tmp_path):
    audio = os.path.relpath(examples / "hello.flac", tmp_path)
    done = command("animate", audio, "--character", "mannequin", "-o", "talk.bvh", S2AG_PYTHON=engine)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "talk.bvh").read_text().startswith("HIERARCHY")
    assert "is taken as the transcript" in done.stderr


def test_the_other_verbs_and_their_errors(command, engine):
    listed = command("styles", S2AG_PYTHON=engine)
    assert listed.returncode == 0 and "calm lecturer" in listed.stdout
    wrong = command("animate", "missing.wav", "-o", "talk.bvh", "--character", "mannequin", S2AG_PYTHON=engine)
    assert wrong.returncode == 2 and wrong.stderr.count("\n") == 1 and "missing.wav" in wrong.stderr


def test_help_tells_of_the_set_up(command, engine):
    done = command("--help", S2AG_PYTHON=engine)
    assert done.returncode == 0 and "s2ag setup" in done.stdout and "animate" in done.stdout
    assert "--wheels" in command("setup", "--help").stdout


def test_without_an_engine_it_says_how_to_get_one(command, tmp_path):
    done = command("styles", S2AG_PYTHON=str(tmp_path / "nowhere"))
    assert done.returncode == 2 and "nowhere cannot be run" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.skipif(not setup.PYTHONS[0] <= sys.version_info[:2] < setup.PYTHONS[1], reason="this Python is not for the engine")
def test_setup_makes_shows_checks_and_removes(command, tmp_path):
    real = pytest.importorskip("av", reason="the engine is not installed")
    packages = wheels.write_wheels(tmp_path / "wheels", linked=Path(real.__file__).parents[1])
    nobody = {"S2AG_PYTHON": None}
    shown = command("setup", "--wheels", packages, "--show", **nobody)
    assert shown.returncode == 0 and "-m venv" in shown.stdout and not list((tmp_path / "home").rglob("engine-1"))
    done = command("setup", "--wheels", packages, **nobody)
    assert done.returncode == 0 and "the engine works" in done.stderr, done.stderr
    assert "Try the engine" in done.stderr and "torch 2.13.0" in done.stderr
    checked = command("setup", "--check", **nobody)
    assert checked.returncode == 0 and str(Path(tmp_path / "home")) in checked.stderr
    assert command("setup", "--remove", **nobody).returncode == 0
    assert not list((tmp_path / "home").rglob("engine-1"))


def test_a_set_up_that_fails_is_one_sentence(command, tmp_path):
    done = command("setup", "--wheels", tmp_path / "nothing")
    assert done.returncode == 2 and "no folder of wheels" in done.stderr and "Traceback" not in done.stderr
