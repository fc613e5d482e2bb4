"""What a failed engine said is kept, for a while."""

import os
import time

import bpy
import pytest
from s2ag.core import files
from s2ag.core.errors import WorkerFailed
from s2ag.s2ag_blender.engine import client, errors_log
from s2ag.s2ag_blender.takes import engine_requests

ENGINE = os.environ.get("S2AG_PYTHON")  # the extension fixture hides it


def test_a_killed_worker_leaves_a_saved_log(extension, examples, monkeypatch):
    try:
        monkeypatch.setenv("S2AG_PYTHON", client.find_interpreter(ENGINE))
    except WorkerFailed as error:
        pytest.skip(str(error))
    engine = client.WorkerClient(log=errors_log.add_line)
    job = engine.request("synthesize", {"audio": str(examples / "hello.flac")})
    time.sleep(0.2)
    os.kill(engine.pid, 9)
    errors_log.add_line("the last words")
    while not job.poll():
        time.sleep(0.01)
    with pytest.raises(WorkerFailed, match="killed by signal 9") as told:
        job.outcome()
    path = errors_log.save(told.value)
    text = path.read_text()
    assert path.is_relative_to(extension / "logs") and "signal 9" in text and "the last words" in text and "Blender:" in text
    assert bpy.ops.s2ag.open_log.poll() and bpy.ops.s2ag.open_log() == {"FINISHED"}
    assert bpy.data.texts[path.name].as_string().startswith("WorkerFailed: The engine was killed by signal 9.")
    engine.close()
    engine_requests.stop_engine()


def test_old_logs_go(tmp_path):
    for _ in range(files.MAX_LOGS + 5):
        files.new_log(tmp_path, "engine").write_text("said")
    assert len(list(tmp_path.glob("*.log"))) == files.MAX_LOGS


def test_help_is_the_readme_and_leaves_texts_of_the_same_name(extension):
    mine = bpy.data.texts.new("README.md")
    for _ in range(2):
        assert bpy.ops.s2ag.open_help() == {"FINISHED"}
    shown = [text for text in bpy.data.texts if "README" in text.name]
    assert len(shown) == 2 and not mine.as_string()
    assert "Five lines to the first gesture" in bpy.data.texts["S2AG README.md"].as_string()
