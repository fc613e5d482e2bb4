"""``blender --command s2ag``: the function that Blender calls, in a process of its own as in Blender."""

import os
import subprocess
import sys

import pytest
from s2ag.core.errors import WorkerFailed
from s2ag.s2ag_blender.engine import client

pytestmark = pytest.mark.slow

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

    def run(*arguments, first="", **variables):
        home = {"BLENDER_USER_RESOURCES": str(tmp_path / "home"), **variables}
        return subprocess.run(
            [sys.executable, "-c", first + START, *map(str, arguments)],
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


def test_help_names_the_verbs(command, engine):
    assert "animate" in command("--help", S2AG_PYTHON=engine).stdout


def test_a_python_without_the_package_is_one_sentence(command, tmp_path):
    subprocess.run([sys.executable, "-I", "-m", "venv", "--without-pip", str(tmp_path / "bare")], check=True)
    bare = tmp_path / "bare" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    hide = "import os; os.environ.pop('PYTHONPATH', None)\n"
    done = command("styles", S2AG_PYTHON=str(bare), first=hide)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert "does not have the package s2ag" in done.stderr and "pip install" in done.stderr


def test_without_an_engine_it_says_how_to_get_one(command, tmp_path):
    done = command("styles", S2AG_PYTHON=str(tmp_path / "nowhere"))
    assert done.returncode == 2 and "nowhere cannot be run" in done.stderr and "Traceback" not in done.stderr
