"""The engine's environment: made from a folder of wheels, cancelled, spoilt, made anew and removed.

The wheels are tiny fakes, so this shows the mechanics; test_trial.py gestures with real packages, and docs/engine.md says how
those were fetched by hand.
"""

import _thread
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
import wheels
from s2ag.core.errors import Cancelled
from s2ag.core.setup import environment, making, planning, trial
from s2ag.core.setup.environment import SetupFailed
from s2ag.core.start import module_command

needs_venv = pytest.mark.skipif(
    not planning.PYTHONS[0] <= sys.version_info[:2] < planning.PYTHONS[1], reason="this Python is not for the engine"
)


@pytest.fixture(scope="module", autouse=True)
def imports_alone():
    """Fakes import, but cannot gesture a clip."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trial, "command", lambda python: module_command(str(python), "core.engine.inventory"))
        yield


@pytest.fixture
def folder(tmp_path):
    """Where an engine is made."""
    return tmp_path / "user"


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
    making.Setup(planning.plan(folder, wheels=str(packages))).wait()
    return environment.environment(folder)


def copied(folder, model):
    shutil.copytree(model, folder / "engine-1", symlinks=True)
    return environment.environment(folder)


def leftovers(folder):
    """Names of what is in the folder but logs, once background deletion had its time."""
    for _ in range(100):
        names = [path.name for path in folder.iterdir() if path.name != "logs"]
        if not names:
            break
        time.sleep(0.05)
    return names


@needs_venv
def test_the_environment_is_made_from_wheels_and_found(folder, packages):
    seen = []
    plan = planning.plan(folder, wheels=str(packages))
    facts = making.Setup(plan).wait(lambda stage, value: seen.append(stage))
    found = environment.environment(folder)
    assert facts["packages"]["torch"] == "2.13.0" and facts["device"] == "cpu" and not found.broken and not found.outdated
    assert list(dict.fromkeys(seen))[0] == "Make the environment" and "Try the engine" in seen
    assert facts["checkpoint"] == "default.safetensors" and facts["commands"] == plan.text
    python = str(found.python)
    assert [environment.chosen(path) for path in (folder, found.folder, python)] == [python] * 3
    command = [python, "-I", "-c", "import torch; print(torch.__file__)"]
    assert str(folder) in subprocess.run(command, capture_output=True, text=True).stdout


@needs_venv
def test_another_replaces_it_only_when_that_works(folder, model, packages, tmp_path):
    first = copied(folder, model)
    poor = wheels.write_wheels(tmp_path / "poor", without=["av"])
    with pytest.raises(SetupFailed) as told:
        making.Setup(planning.plan(folder, wheels=str(poor))).wait()
    assert told.value.message.startswith("There is no av") and "wheels" in told.value.remedy
    assert environment.environment(folder).folder == first.folder
    assert told.value.log.parent == folder / "logs" and "No matching distribution" in told.value.log.read_text()

    work = making.Setup(planning.plan(folder, wheels=str(packages)))
    work.wait()
    second = environment.environment(folder)
    assert second.folder != first.folder
    work.cleaner.join()
    assert not first.folder.exists() and environment.environment(folder).folder == second.folder


@needs_venv
def test_remove_leaves_nothing_but_logs(folder, model):
    copied(folder, model)
    (folder / "logs").mkdir()
    (folder / "engine-2").mkdir()  # half-made
    planning.remove(folder)
    assert [path.name for path in folder.iterdir()] == ["logs"] and environment.environment(folder) is None
    with pytest.raises(SetupFailed, match="No engine is in"):
        environment.chosen(folder)


@needs_venv
@pytest.mark.parametrize("step", ["Make the environment", "Install packages"])
def test_cancel_answers_within_half_a_second_and_leaves_nothing(folder, tmp_path, step):
    heavy = wheels.write_wheels(tmp_path / "heavy", size=400_000_000)
    work = making.Setup(planning.plan(folder, wheels=str(heavy)))
    deadline = time.monotonic() + 60
    while work.stage != step and time.monotonic() < deadline:
        assert not work.poll()
        time.sleep(0.01)
    started = time.monotonic()
    work.cancel()
    assert work.poll() and time.monotonic() - started < 0.5
    assert isinstance(work.error, Cancelled)
    work.cleaner.join(10)
    assert not leftovers(folder) and environment.environment(folder) is None


@needs_venv
@pytest.mark.slow
def test_the_recogniser_is_added_when_it_is_wanted(folder, packages, tmp_path):
    plain = making.Setup(planning.plan(folder, wheels=str(packages))).wait()
    assert not plain["recogniser"]
    poor = wheels.write_wheels(tmp_path / "poor", without=["faster-whisper"])
    with pytest.raises(SetupFailed, match="There is no faster-whisper"):
        making.Setup(planning.plan(folder, wheels=str(poor), recognise=True)).wait()
    facts = making.Setup(planning.plan(folder, wheels=str(packages), recognise=True)).wait()
    found = environment.environment(folder)
    assert facts["recogniser"] and found.recognises and not found.outdated


@needs_venv
def test_an_environment_that_somebody_else_is_making_is_left_alone(folder, model):
    keep = copied(folder, model)
    fresh, stale = folder / "engine-2", folder / "engine-3"
    for place in (fresh, stale):
        place.mkdir()
        (place / "building").touch()
    for place in (stale / "building", stale):
        os.utime(place, (1, 1))
    planning.tidy(folder, keep.folder).join()
    assert keep.folder.exists() and fresh.exists() and not stale.exists()


@needs_venv
def test_packages_that_do_not_work_are_not_made_active(folder, tmp_path):
    bad = wheels.write_wheels(tmp_path / "bad", without=["torch"])
    wheels.write_wheel(bad, "torch", "torch.py", "2.13.0", "raise ImportError('a library is missing')")
    with pytest.raises(SetupFailed, match="torch does not load: a library is missing"):
        made(folder, bad)
    assert environment.environment(folder) is None


@needs_venv
def test_a_full_disk(folder, packages, tmp_path, monkeypatch):
    place = tmp_path / "small"
    place.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(place)], capture_output=True).returncode:
        pytest.skip("no small disk can be mounted here")
    try:
        with pytest.raises(SetupFailed, match="GB are free"):
            planning.plan(place / "user", wheels=str(packages))
        monkeypatch.setattr(environment, "SIZES", {True: (0, 0), False: (0, 0)})
        monkeypatch.setattr(planning, "SPARE", 0)
        work = making.Setup(planning.plan(place / "user", wheels=str(packages)))
        with pytest.raises(SetupFailed, match="disk is full"):
            work.wait()
        work.cleaner.join(10)
        assert environment.environment(place / "user") is None and not leftovers(place / "user")
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


@needs_venv
def test_a_folder_that_cannot_be_written_to(packages, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(SetupFailed, match="cannot be made"):
        making.Setup(planning.plan(tmp_path / "file" / "user", wheels=str(packages)))


def test_no_wheels_in_the_folder(tmp_path):
    with pytest.raises(SetupFailed, match="no folder of wheels"):
        planning.plan(tmp_path / "user", wheels=str(tmp_path))


def test_a_python_that_cannot_be_used_is_said(tmp_path, monkeypatch):
    with pytest.raises(SetupFailed, match="cannot be run"):
        planning.find_python(str(tmp_path / "python"))
    script = tmp_path / "old"
    script.write_text("#!/bin/sh\necho '[[3, 9], []]'\n")
    script.chmod(0o755)
    with pytest.raises(SetupFailed, match="is version 3.9"):
        planning.find_python(str(script))
    monkeypatch.setattr(planning, "PYTHONS", ((4, 0), (4, 1)))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SetupFailed, match="No Python from 3.11 to 3.13"):
        planning.find_python()


def test_the_newest_finished_environment_is_the_engine(tmp_path):
    for number, facts in ((1, {"n": 1}), (2, {"n": 2}), (10, None), (11, "half")):
        place = tmp_path / f"engine-{number}"
        place.mkdir()
        if facts is not None:
            (place / "engine.json").write_text(json.dumps(facts) if isinstance(facts, dict) else "{")
    found = environment.environment(tmp_path)
    assert found.facts == {"n": 2} and found.broken and found.outdated


def test_the_requirements_are_those_of_the_project(monkeypatch):
    assert "pocketsphinx==5.1.1" in environment.requirements()
    assert planning.SMALL_TORCH in planning.wanted(small=True) and "torch>=2.4,<2.14" not in planning.wanted(small=True)
    assert "torch>=2.4,<2.14" in planning.wanted()
    monkeypatch.setenv("S2AG_TORCH", "torch==2.13.0")
    assert "torch==2.13.0" in planning.wanted(small=True) and "torch>=2.4,<2.14" not in planning.wanted()


@pytest.mark.parametrize("facts", ["", "[" * 100_000, "[]", '{"a": ' + "9" * 5000 + "}", " " * 2_000_000])
def test_other_folders_and_damaged_facts_are_no_engine(tmp_path, facts):
    (tmp_path / "engine-²").mkdir()
    (tmp_path / "engine-2").mkdir()
    (tmp_path / "engine-2" / "engine.json").write_text(facts)
    found = environment.environment(tmp_path)
    assert found is None or found.facts == {"a": float("inf")}


@pytest.mark.parametrize("step", [1, 2, 3])
def test_a_signal_while_any_step_starts_its_process_leaves_neither_processes_nor_files(folder, tmp_path, monkeypatch, step):
    started, popen = [], subprocess.Popen
    (tmp_path / "any.whl").touch()
    plan = planning.plan(folder, wheels=str(tmp_path))
    forever = [sys.executable, "-c", "import time; time.sleep(600)"]
    steps = [[sys.executable, "-c", "pass"]] * (step - 1) + [forever] * 3
    monkeypatch.setattr(planning.Plan, "make", property(lambda self: steps[0]))
    monkeypatch.setattr(planning.Plan, "fill", property(lambda self: steps[1]))
    monkeypatch.setattr(trial, "command", lambda python: steps[2])

    def start(*command, **options):
        if command[0] is forever:
            _thread.interrupt_main()
            time.sleep(0.2)
        started.append(popen(*command, **options))
        return started[-1]

    monkeypatch.setattr(trial.subprocess, "Popen", start)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            making.Setup(plan).wait()
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(started) == step and [one.wait(10) is not None for one in started] == [True] * step
    assert not leftovers(folder)
