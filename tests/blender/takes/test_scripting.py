"""The scripts of docs/scripting.md, run as they stand there."""

import json
import re
from pathlib import Path

import bpy
import pytest
import s2ag
from s2ag.core.errors import WorkerFailed
from s2ag.s2ag_blender.engine import client

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "scripting.md").read_text("utf-8")
WITHOUT_BLENDER, ON_AN_ARMATURE, A_MOTION, FOR_PROGRAMS = re.findall(r"```python\n(.*?)```", PAGE, re.S)


@pytest.fixture
def figure(monkeypatch, examples):
    s2ag.register()
    bpy.ops.s2ag.add_mannequin()
    figure = bpy.context.object
    figure.name = "Armature"
    monkeypatch.chdir(examples)
    yield figure
    s2ag.unregister()


def test_a_dozen_lines_make_a_character_gesture(figure, capsys):
    try:
        client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))
    script = ON_AN_ARMATURE.replace("talk.flac", "hello.flac")
    assert len([line for line in script.splitlines() if line.strip()]) <= 12
    exec(compile(script, "docs/scripting.md", "exec"), {})
    action = figure.animation_data.action
    assert action.frame_range[0] == 11 and action.name in capsys.readouterr().out


def test_a_program_is_told_what_was_made_and_what_is_wrong(figure, capsys):
    try:
        client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))
    names: dict = {}
    exec(compile(FOR_PROGRAMS.replace("talk.flac", "hello.flac"), "docs/scripting.md", "exec"), names)
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    action = figure.animation_data.action
    assert told["action"] == action.name and told["frames"] == list(action.frame_range) and told["seed"] == 3
    assert told["gestures"] and all(told["frames"][0] <= frame <= told["frames"][1] for frame, *_ in told["gestures"])
    count = len(bpy.data.actions)
    wrong = names["talk"](figure, "gone.flac", "hello there")
    assert wrong["error"] and wrong["remedy"] and len(bpy.data.actions) == count


def test_a_motion_that_was_made_elsewhere(figure, wave, tmp_path):
    wave(30).save(tmp_path / "talk.npz")
    exec(compile(A_MOTION.replace("talk.npz", str(tmp_path / "talk.npz")), "docs/scripting.md", "exec"), {"bpy": bpy})
    assert figure.animation_data.action


def test_a_session_stays_warm(tmp_path, examples):
    pytest.importorskip("av", reason="reads FLAC; not beside every Blender")
    script = WITHOUT_BLENDER.replace("talk.flac", str(examples / "hello.flac")).replace('f"talk_', f'f"{tmp_path}/talk_')
    exec(compile(script, "docs/scripting.md", "exec"), {})
    assert len(list(tmp_path.glob("talk_*.npz"))) == 3
