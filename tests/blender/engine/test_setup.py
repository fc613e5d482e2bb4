"""The engine's environment: made from a folder of wheels, cancelled, spoilt, mended and removed.

The wheels are tiny fakes, so this shows the mechanics; test_trial.py gestures with real packages, and docs/engine.md says how
those were fetched by hand.
"""

import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import bpy
import pytest
import wheels
from acted import drawn
from s2ag.core.errors import Cancelled, WorkerFailed
from s2ag.s2ag_blender.engine import client, errors_log, known, run, setup
from s2ag.s2ag_blender.ui import engine_ops

ROOT = Path(__file__).resolve().parents[3]
ENGINE = os.environ.get("S2AG_PYTHON")  # the extension fixture hides it
needs_venv = pytest.mark.skipif(
    not setup.PYTHONS[0] <= sys.version_info[:2] < setup.PYTHONS[1], reason="this Python is not for the engine"
)


@pytest.fixture(scope="module", autouse=True)
def imports_alone():
    """Fakes import, but cannot gesture a clip."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(setup, "trial_command", lambda python: client.module_command(str(python), "core.engine.inventory"))
        yield


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return wheels.write_wheels(tmp_path_factory.mktemp("packages") / "wheels")


@pytest.fixture(scope="module")
def model(tmp_path_factory, packages):
    """An environment that the set-up made, for copies: making one takes seconds."""
    folder = tmp_path_factory.mktemp("model")
    made(folder, packages)
    return folder / "engine-1"


def made(folder, packages):
    run.Setup(setup.plan(folder, wheels=str(packages))).wait()
    return setup.environment(folder)


def copied(folder, model):
    shutil.copytree(model, folder / "engine-1", symlinks=True)
    return setup.environment(folder)


def leftovers(folder):
    """Names of what is in the folder but logs, once background deletion had its time."""
    for _ in range(100):
        names = [path.name for path in folder.iterdir() if path.name != "logs"]
        if not names:
            break
        time.sleep(0.05)
    return names


@needs_venv
def test_the_environment_is_made_from_wheels_and_found_by_itself(extension, packages):
    seen = []
    plan = setup.plan(extension, wheels=str(packages))
    facts = engine_ops.set_up(bpy.context, plan, lambda stage, value: seen.append(stage))
    found = known.engine()
    assert facts["packages"]["torch"] == "2.13.0" and facts["device"] == "cpu" and not found.broken and not found.outdated
    assert list(dict.fromkeys(seen))[0] == "Make the environment" and "Try the engine" in seen
    python = known.interpreter(bpy.context)
    assert Path(python).is_relative_to(extension) and client.find_interpreter(python) == python
    assert not known.ships(bpy.context) and known.facts()["checkpoint"] == "default.safetensors"
    command = [python, "-I", "-c", "import torch; print(torch.__file__)"]
    assert str(extension) in subprocess.run(command, capture_output=True, text=True).stdout


@needs_venv
def test_repair_replaces_it_only_when_the_new_one_works(extension, model, packages, tmp_path):
    first = copied(extension, model)
    poor = wheels.write_wheels(tmp_path / "poor", without=["av"])
    with pytest.raises(setup.SetupFailed) as told:
        engine_ops.set_up(bpy.context, setup.plan(extension, wheels=str(poor)))
    assert told.value.message.startswith("There is no av") and "wheels" in told.value.remedy
    assert setup.environment(extension).folder == first.folder
    assert errors_log.latest() == told.value.log and "No matching distribution" in told.value.log.read_text()
    assert bpy.ops.s2ag.open_log() == {"FINISHED"}
    assert "No matching distribution" in bpy.data.texts[told.value.log.name].as_string()

    work = run.Setup(setup.plan(extension, wheels=str(packages)))
    work.wait()
    second = setup.environment(extension)
    assert second.folder != first.folder
    work.cleaner.join()
    assert not first.folder.exists() and setup.environment(extension).folder == second.folder


@needs_venv
def test_remove_leaves_nothing_but_logs(extension, model):
    copied(extension, model)
    (extension / "logs").mkdir()
    (extension / "engine-2").mkdir()  # half-made
    assert bpy.ops.s2ag.engine_remove() == {"FINISHED"}
    assert [path.name for path in extension.iterdir()] == ["logs"]
    assert known.engine() is None and not bpy.ops.s2ag.engine_remove.poll()


@needs_venv
def test_an_environment_that_another_blender_is_making_is_left_alone(extension, model):
    keep = copied(extension, model)
    fresh, stale = extension / "engine-2", extension / "engine-3"
    for place in (fresh, stale):
        place.mkdir()
        (place / "building").touch()
    for place in (stale / "building", stale):
        os.utime(place, (1, 1))
    setup.tidy(extension, keep.folder).join()
    assert keep.folder.exists() and fresh.exists() and not stale.exists()


@needs_venv
@pytest.mark.parametrize("step", ["Make the environment", "Install packages"])
def test_cancel_answers_within_half_a_second_and_leaves_nothing(extension, tmp_path, step):
    heavy = wheels.write_wheels(tmp_path / "heavy", size=400_000_000)
    work = engine_ops.begin(bpy.context, setup.plan(extension, wheels=str(heavy)))
    deadline = time.monotonic() + 60
    while work.stage != step and time.monotonic() < deadline:
        assert engine_ops.tick()
        time.sleep(0.01)
    started = time.monotonic()
    assert bpy.ops.s2ag.engine_cancel() == {"FINISHED"}
    assert not engine_ops.tick() and time.monotonic() - started < 0.5
    assert isinstance(work.error, Cancelled) and known.STATE.work is None and known.STATE.error is None
    work.cleaner.join(10)
    assert not leftovers(extension) and setup.environment(extension) is None


@pytest.mark.slow
@needs_venv
def test_the_recogniser_is_added_when_it_is_wanted(extension, packages, tmp_path):
    assert "faster-whisper" not in known.planned(bpy.context, check=False).text
    plain = engine_ops.set_up(bpy.context, setup.plan(extension, wheels=str(packages)))
    assert not plain["recogniser"] and known.recogniser(bpy.context) is False
    shown = panel_with_recogniser()
    assert "The engine has no speech recogniser yet" in " ".join(shown) and shown["s2ag.engine_setup"]
    with pytest.raises(RuntimeError, match="no speech recogniser"):
        bpy.ops.s2ag.generate()
    poor = wheels.write_wheels(tmp_path / "poor", without=["faster-whisper"])
    with pytest.raises(setup.SetupFailed, match="There is no faster-whisper"):
        engine_ops.set_up(bpy.context, setup.plan(extension, wheels=str(poor), recognise=True))
    facts = engine_ops.set_up(bpy.context, setup.plan(extension, wheels=str(packages), recognise=True))
    found = setup.environment(extension)
    assert facts["recogniser"] and found.recognises and not found.outdated
    assert "English speech only" in panel_with_recogniser() and bpy.ops.s2ag.generate.poll()


def panel_with_recogniser():
    """What the panel shows for a mannequin whose words are to be recognised."""
    if bpy.context.active_object is None:
        bpy.ops.s2ag.add_mannequin()
    bpy.context.active_object.s2ag.audio, bpy.context.active_object.s2ag.transcript_source = __file__, "RECOGNISE"
    return drawn()


@needs_venv
def test_progress_of_the_set_up_shows_in_the_panel(extension, packages):
    work = engine_ops.begin(bpy.context, setup.plan(extension, wheels=str(packages)))
    shown = panel_with_recogniser()
    assert work.stage in shown and shown["s2ag.engine_cancel"] and "s2ag.generate" not in shown
    engine_ops.stop()
    work.cleaner.join(10)
    assert "s2ag.engine_cancel" not in drawn()


def test_the_button_of_the_panel_asks_for_the_recogniser(extension):
    operator = bpy.ops.s2ag.engine_setup.get_rna_type()
    assert operator.properties["recognise"].type == "BOOLEAN"
    plans = [known.planned(bpy.context, recognise=recognise) for recognise in (False, True)]
    assert ["faster-whisper" in plan.text for plan in plans] == [False, True]
    with pytest.raises(RuntimeError, match="Online access is off"):
        bpy.ops.s2ag.engine_setup(recognise=True)


@needs_venv
def test_unregistering_ends_the_work(extension, packages):
    work = engine_ops.begin(bpy.context, setup.plan(extension, wheels=str(packages)))
    engine_ops.stop()
    assert work.done and known.STATE.work is None
    work.cleaner.join(10)
    assert not leftovers(extension)


@needs_venv
def test_packages_that_do_not_work_are_not_made_active(extension, tmp_path):
    bad = wheels.write_wheels(tmp_path / "bad", without=["torch"])
    wheels.write_wheel(bad, "torch", "torch.py", "2.13.0", "raise ImportError('a library is missing')")
    with pytest.raises(setup.SetupFailed, match="torch does not load: a library is missing"):
        made(extension, bad)
    assert setup.environment(extension) is None


@needs_venv
def test_a_full_disk(extension, packages, tmp_path, monkeypatch):
    place = tmp_path / "small"
    place.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(place)], capture_output=True).returncode:
        pytest.skip("no small disk can be mounted here")
    try:
        with pytest.raises(setup.SetupFailed, match="GB are free"):
            setup.plan(place / "user", wheels=str(packages))
        monkeypatch.setattr(setup, "SIZES", {True: (0, 0), False: (0, 0)})
        monkeypatch.setattr(setup, "SPARE", 0)
        work = run.Setup(setup.plan(place / "user", wheels=str(packages)))
        with pytest.raises(setup.SetupFailed, match="disk is full"):
            work.wait()
        work.cleaner.join(10)
        assert setup.environment(place / "user") is None and not leftovers(place / "user")
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


@needs_venv
def test_a_folder_that_cannot_be_written_to(packages, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(setup.SetupFailed, match="cannot be made"):
        run.Setup(setup.plan(tmp_path / "file" / "user", wheels=str(packages)))


def test_no_wheels_in_the_folder(tmp_path):
    with pytest.raises(setup.SetupFailed, match="no folder of wheels"):
        setup.plan(tmp_path / "user", wheels=str(tmp_path))


def test_a_python_that_cannot_be_used_is_said(tmp_path, monkeypatch):
    with pytest.raises(setup.SetupFailed, match="cannot be run"):
        setup.find_python(str(tmp_path / "python"))
    script = tmp_path / "old"
    script.write_text("#!/bin/sh\necho '[[3, 9], []]'\n")
    script.chmod(0o755)
    with pytest.raises(setup.SetupFailed, match="is version 3.9"):
        setup.find_python(str(script))
    monkeypatch.setattr(setup, "PYTHONS", ((4, 0), (4, 1)))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(setup.SetupFailed, match="No Python from 3.11 to 3.13"):
        setup.find_python()


def test_the_newest_finished_environment_is_the_engine(tmp_path):
    for number, facts in ((1, {"n": 1}), (2, {"n": 2}), (10, None), (11, "half")):
        place = tmp_path / f"engine-{number}"
        place.mkdir()
        if facts is not None:
            (place / "engine.json").write_text(json.dumps(facts) if isinstance(facts, dict) else "{")
    found = setup.environment(tmp_path)
    assert found.facts == {"n": 2} and found.broken and found.outdated


def test_the_commands_are_shown_before_they_run(extension):
    plan = known.planned(bpy.context, check=False)
    assert plan.text.splitlines()[0].endswith(f"-m venv {extension / 'engine-1'}")
    torch = "torch==2.13.0+cpu" if sys.platform == "linux" else "torch>=2.4,<2.14"
    assert torch in plan.text and "--only-binary :all:" in plan.text
    assert not (extension / "engine-1").exists()


def test_the_requirements_are_those_of_the_project(monkeypatch):
    assert "pocketsphinx==5.1.1" in setup.requirements()
    assert setup.SMALL_TORCH in setup.wanted(small=True) and "torch>=2.4,<2.14" not in setup.wanted(small=True)
    assert "torch>=2.4,<2.14" in setup.wanted()
    monkeypatch.setenv("S2AG_TORCH", "torch==2.13.0")
    assert "torch==2.13.0" in setup.wanted(small=True) and "torch>=2.4,<2.14" not in setup.wanted()


def test_offline(extension, monkeypatch):
    """Row "Offline": the registry is used by the set-up alone, and not at all while Blender's online access is off.

    The manifest asks for the network because of that one button, and says so; docs/engine.md explains.
    """

    class App:
        online_access = False

    monkeypatch.setattr(engine_ops.bpy, "app", App, raising=False)
    with pytest.raises(setup.SetupFailed, match="Online access is off"):
        engine_ops.set_up(bpy.context)
    assert not extension.exists() or not list(extension.glob("engine-*"))
    monkeypatch.undo()
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert "Set Up Engine" in manifest["permissions"]["network"]
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
        command = client.module_command(python, "core.engine.worker")
        with client.WorkerClient(command=[python, "-P", *command[2:]]) as worker:  # isolated it would not see the hook
            told = worker.call("synthesize", {"audio": str(examples / "hello.flac")})
            assert told["motions"]
        probe = [python, "-c", "import socket; socket.getaddrinfo('localhost', 80)"]
        assert subprocess.run(probe).returncode == 77  # the hook does its work
    finally:
        os.environ["PYTHONPATH"] = environment


def test_check_says_what_was_found_or_what_is_missing(extension, monkeypatch, tmp_path):
    bare = tmp_path / "bare"
    subprocess.run([sys.executable, "-I", "-m", "venv", "--without-pip", str(bare)], check=True)
    monkeypatch.setenv("S2AG_PYTHON", str(setup.python_in(bare)))
    known.look(None)
    with pytest.raises(RuntimeError, match="cannot run the engine|does not work"):
        bpy.ops.s2ag.engine_check()
