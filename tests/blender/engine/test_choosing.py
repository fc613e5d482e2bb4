"""The full engine from Blender: a Python that works is chosen, one that does not is not, and nothing fetches or installs."""

import os
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import bpy
import pytest
from acted import drawn
from s2ag.core import optional_packages
from s2ag.core.errors import Cancelled, WorkerFailed
from s2ag.core.start import module_command
from s2ag.s2ag_blender.engine import client, engine_state, errors_log
from s2ag.s2ag_blender.ui import engine_ops

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
@pytest.fixture
def bare(tmp_path, monkeypatch):
    """A Python that has nothing."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    place = tmp_path / "bare"
    subprocess.run([sys.executable, "-I", "-m", "venv", "--without-pip", str(place)], check=True)
    return place


@pytest.fixture
def slow(tmp_path):
    """A program that says nothing for a minute."""
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\nsleep 60\n")
    program.chmod(0o755)
    return str(program)


def panel_with_recogniser():
    """What the panel shows for a mannequin whose words are to be recognised."""
    if bpy.context.active_object is None:
        bpy.ops.s2ag.add_mannequin()
    bpy.context.active_object.s2ag.audio, bpy.context.active_object.s2ag.transcript_source = __file__, "RECOGNISE"
    return drawn()


@pytest.fixture
def old_set_up(tmp_path):
    """The folder of an earlier version's set-up command: environments of which the newest is in use."""
    for name, python in (("engine-9", "gone"), ("engine-10", sys.executable)):
        (tmp_path / "old" / name / "bin").mkdir(parents=True)
        (tmp_path / "old" / name / "bin" / "python").symlink_to(python)
    return tmp_path / "old"


def test_a_python_that_works_is_chosen_and_left_again(extension, monkeypatch):
    pytest.importorskip("torch", reason="a full engine has PyTorch")
    assert engine_state.is_bundled(bpy.context)
    assert bpy.ops.s2ag.engine_choose(filepath=sys.executable) == {"FINISHED"}
    assert engine_state.interpreter(bpy.context) == client.find_interpreter(sys.executable) and not engine_state.is_bundled(
        bpy.context
    )
    assert engine_state.facts()["checkpoint"] == "default.safetensors" and engine_state.facts()["packages"]["torch"]
    assert engine_state.has_recogniser(bpy.context) == optional_packages.has_recogniser()
    engine_state.forget()  # as after a start of Blender
    assert (
        engine_state.has_recogniser(bpy.context) is None
        and bpy.ops.s2ag.engine_check() == {"FINISHED"}
        and engine_state.facts()
    )
    assert bpy.ops.s2ag.engine_leave() == {"FINISHED"}
    assert engine_state.is_bundled(bpy.context) and not bpy.ops.s2ag.engine_leave.poll()


def test_a_stored_choice_of_an_earlier_version_still_works(extension, old_set_up):
    engine_state.choose(bpy.context, str(old_set_up))
    python = engine_state.interpreter(bpy.context)
    assert Path(python) == old_set_up / "engine-10" / "bin" / "python" and client.find_interpreter(python) == python


def test_an_engine_that_does_not_work_is_not_kept(extension, bare):
    with pytest.raises(RuntimeError, match="does not have the package s2ag.*pip install"):
        bpy.ops.s2ag.engine_choose(filepath=str(bare))
    assert engine_state.is_bundled(bpy.context) and engine_state.STATE.error is not None
    assert "No module named" in errors_log.latest().read_text() and bpy.ops.s2ag.open_log() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="There is no Python in"):
        bpy.ops.s2ag.engine_choose(filepath=str(bare.parent))


def test_check_says_what_is_missing(extension, monkeypatch, bare):
    monkeypatch.setenv("S2AG_PYTHON", str(bare / "bin" / "python"))
    with pytest.raises(RuntimeError, match="does not have the package s2ag"):
        bpy.ops.s2ag.engine_check()


def test_a_check_blocks_nothing_and_can_be_stopped(extension, slow):
    """What the operators do in a window: begin, follow by a timer, stop."""
    started = time.monotonic()
    work = engine_ops.begin(bpy.context, slow)
    assert engine_ops.tick() and not bpy.ops.s2ag.engine_choose.poll()
    shown = panel_with_recogniser()
    assert work.stage in shown and shown["s2ag.engine_cancel"] and "s2ag.generate" not in shown
    assert bpy.ops.s2ag.engine_cancel() == {"FINISHED"} and not engine_ops.tick()
    assert time.monotonic() - started < 20 and isinstance(work.error, Cancelled)
    assert engine_state.STATE.work is None and engine_state.STATE.error is None and engine_state.is_bundled(bpy.context)
    assert "s2ag.engine_cancel" not in drawn()


def test_unregistering_ends_the_check(extension, slow):
    work = engine_ops.begin(bpy.context, slow)
    engine_ops.stop()
    assert work.done and engine_state.STATE.work is None


def test_the_panel_leads_to_the_recogniser(extension):
    if engine_state.has_recogniser(bpy.context):
        pytest.skip("this Python has the recogniser")
    shown = panel_with_recogniser()
    assert "The engine has no speech recognizer yet" in " ".join(shown)
    assert shown["s2ag.engine_choose"]
    with pytest.raises(RuntimeError, match="no speech recognizer"):
        bpy.ops.s2ag.generate()


def test_offline(extension):
    """No permission for the network, and no module that could open a connection is imported."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert set(manifest["permissions"]) == {"files"} and "wheels" not in manifest
    reaching = ("import socket", "import urllib", "import http", "requests", "import ssl", "import ftplib")
    sources = [path for folder in ("core", "rigs", "s2ag_blender") for path in (ROOT / folder).rglob("*.py")]
    found = [path.name for path in sources for word in reaching if f"\n{word}" in path.read_text("utf-8")]
    assert not found


def test_no_connection_is_opened_while_gestures_are_made(examples, tmp_path):
    """The worker runs with a hook that ends it at the first socket or look-up of a host."""
    try:
        python = client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))
    hook = tmp_path / "hook"
    hook.mkdir()
    (hook / "sitecustomize.py").write_text(
        "import os, sys\n"
        "def watch(event, args):\n"
        "    if event in ('socket.connect', 'socket.getaddrinfo', 'socket.bind'):\n"
        "        os._exit(77)\n"
        "sys.addaudithook(watch)\n"
    )
    environment = os.environ.get("PYTHONPATH", "")
    os.environ["PYTHONPATH"] = str(hook)
    try:
        command = module_command("core.worker.server")
        with client.WorkerClient(command=[python, "-P", *command[2:]]) as worker:  # isolated it would not see the hook
            told = worker.call("synthesize", {"audio": str(examples / "hello.flac")})
            assert told["motions"]
        probe = [python, "-c", "import socket; socket.getaddrinfo('localhost', 80)"]
        assert subprocess.run(probe).returncode == 77  # the hook does its work
    finally:
        os.environ["PYTHONPATH"] = environment


def test_interpreter_is_the_named_one_or_this_one(monkeypatch):
    assert client.find_interpreter(sys.executable) == sys.executable
    monkeypatch.setenv("S2AG_PYTHON", "/no/such/python")
    with pytest.raises(WorkerFailed, match="/no/such/python"):
        client.find_interpreter()
    monkeypatch.setenv("S2AG_PYTHON", "")
    assert client.find_interpreter() == sys.executable
    monkeypatch.setattr(client.sys, "executable", "/usr/bin/blender")
    with pytest.raises(WorkerFailed, match="Blender's own Python cannot be started") as caught:
        client.find_interpreter()
    assert "S2AG_PYTHON" in caught.value.remedy
