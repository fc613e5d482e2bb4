"""The full engine from Blender: its command is shown and copied, one that works is chosen, and nothing fetches or installs."""

import os
import shlex
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import bpy
import pytest
import wheels
from acted import drawn
from imports import modules, reachable
from s2ag.core.errors import Cancelled, WorkerFailed
from s2ag.core.setup import making, planning, trial
from s2ag.core.start import module_command
from s2ag.s2ag_blender.engine import client, errors_log, known
from s2ag.s2ag_blender.ui import engine_ops

ROOT = Path(__file__).resolve().parents[3]
needs_venv = pytest.mark.skipif(
    not planning.PYTHONS[0] <= sys.version_info[:2] < planning.PYTHONS[1], reason="this Python is not for the engine"
)


@pytest.fixture
def made(monkeypatch, tmp_path):
    """An environment of fakes, which import but cannot gesture, with the recogniser, as the set-up command leaves it."""
    monkeypatch.setattr(trial, "command", lambda python: module_command(str(python), "core.engine.inventory"))
    packages = wheels.write_wheels(tmp_path / "wheels")
    making.Setup(planning.plan(tmp_path / "engine", wheels=str(packages), recognise=True)).wait()
    return tmp_path / "engine"


@pytest.fixture
def bare(tmp_path):
    """A Python that has nothing."""
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


@needs_venv
def test_an_engine_that_works_is_chosen_and_left_again(extension, made):
    assert known.ships(bpy.context)
    assert bpy.ops.s2ag.engine_choose(filepath=str(made)) == {"FINISHED"}
    python = known.interpreter(bpy.context)
    assert Path(python).is_relative_to(made) and client.find_interpreter(python) == python
    assert not known.ships(bpy.context) and known.facts()["checkpoint"] == "default.safetensors"
    assert known.engine().recognises and known.recogniser(bpy.context)
    assert "English speech only" in panel_with_recogniser() and bpy.ops.s2ag.generate.poll()
    known.look(bpy.context)  # as after a start of Blender
    assert known.facts()["interpreter"] == python
    assert bpy.ops.s2ag.engine_leave() == {"FINISHED"}
    assert known.ships(bpy.context) and made.exists() and not bpy.ops.s2ag.engine_leave.poll()


def test_an_engine_that_does_not_work_is_not_kept(extension, bare):
    with pytest.raises(RuntimeError, match="cannot run the engine|does not work"):
        bpy.ops.s2ag.engine_choose(filepath=str(bare))
    assert known.ships(bpy.context) and known.STATE.error is not None
    assert "numpy" in errors_log.latest().read_text() and bpy.ops.s2ag.open_log() == {"FINISHED"}
    with pytest.raises(RuntimeError, match="No engine is in"):
        bpy.ops.s2ag.engine_choose(filepath=str(bare.parent))


def test_check_says_what_is_missing(extension, monkeypatch, bare):
    monkeypatch.setenv("S2AG_PYTHON", str(bare / "bin" / "python"))
    with pytest.raises(RuntimeError, match="cannot run the engine|does not work"):
        bpy.ops.s2ag.engine_check()


def test_trying_holds_nothing_and_can_be_stopped(extension, slow):
    """What the operators do in a window: begin, follow by a timer, stop."""
    started = time.monotonic()
    work = engine_ops.begin(bpy.context, slow)
    assert engine_ops.tick() and not bpy.ops.s2ag.engine_choose.poll()
    shown = panel_with_recogniser()
    assert work.stage in shown and shown["s2ag.engine_cancel"] and "s2ag.generate" not in shown
    assert bpy.ops.s2ag.engine_cancel() == {"FINISHED"} and not engine_ops.tick()
    assert time.monotonic() - started < 20 and isinstance(work.error, Cancelled)
    assert known.STATE.work is None and known.STATE.error is None and known.ships(bpy.context)
    assert "s2ag.engine_cancel" not in drawn()


def test_unregistering_ends_the_trial(extension, slow):
    work = engine_ops.begin(bpy.context, slow)
    engine_ops.stop()
    assert work.done and known.STATE.work is None


def test_the_command_runs_outside_blender(extension):
    """What is copied says by itself, in a Python that needs nothing, what it would do."""
    command = shlex.split(known.set_up_command(bpy.context, recognise=True))
    assert command[-2:] == [str(Path.home() / known.FOLDER), "--recognise"]
    done = subprocess.run([*command, "--show"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    torch = "torch==2.13.0+cpu" if sys.platform == "linux" else "torch>=2.4,<2.14"
    assert torch in done.stdout and "faster-whisper" in done.stdout and "GB" in done.stdout
    assert bpy.ops.s2ag.copy_command() == {"FINISHED"}


def test_the_panel_leads_to_the_recogniser(extension):
    if known.recogniser(bpy.context):
        pytest.skip("this Python has the recogniser")
    shown = panel_with_recogniser()
    assert "The engine has no speech recogniser yet" in " ".join(shown)
    assert shown["s2ag.copy_command"] and shown["s2ag.engine_choose"]
    with pytest.raises(RuntimeError, match="no speech recogniser"):
        bpy.ops.s2ag.generate()


def test_offline(extension):
    """Row "Offline": no permission for the network, and nothing in Blender's process reaches what makes environments."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert set(manifest["permissions"]) == {"files", "clipboard"} and "wheels" not in manifest
    makers = {"core.setup.making", "core.setup.planning", "core.setup.pip", "core.cli.engine"}
    assert makers <= set(modules("core"))
    assert "core.setup.trial" in reachable("s2ag_blender.registration") and not reachable("s2ag_blender.registration") & makers
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
        command = module_command(python, "core.engine.worker")
        with client.WorkerClient(command=[python, "-P", *command[2:]]) as worker:  # isolated it would not see the hook
            told = worker.call("synthesize", {"audio": str(examples / "hello.flac")})
            assert told["motions"]
        probe = [python, "-c", "import socket; socket.getaddrinfo('localhost', 80)"]
        assert subprocess.run(probe).returncode == 77  # the hook does its work
    finally:
        os.environ["PYTHONPATH"] = environment
