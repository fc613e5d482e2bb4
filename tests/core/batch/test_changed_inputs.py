"""What is made of a file that changes on the way is not believed to be of the file that was looked at."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.batch import manifest, stages, tasks
from s2ag.core.batch.folder import Folder
from s2ag.core.errors import S2agError
from sounds import write_wav

HELLO = Path(__file__).parents[3] / "examples" / "hello.flac"


def other_sound(path):
    write_wav(path, np.random.default_rng(0).normal(0, 0.1, 1600))


def other_words(path):
    path.write_text("no, not at all", "utf-8")


@pytest.mark.parametrize(("name", "change"), [("a.flac", other_sound), ("a.txt", other_words)])
def test_a_file_that_is_replaced_between_its_key_and_its_reading_is_told(tmp_path, name, change):
    shutil.copy(HELLO, tmp_path / "a.flac")
    (tmp_path / "a.txt").write_text("hello there", "utf-8")
    table = tmp_path / "clips.jsonl"
    table.write_text(json.dumps({"name": "a", "audio": "a.flac", "transcript": "a.txt"}) + "\n", "utf-8")
    batch = stages.Batch(Folder(tmp_path / "out"), manifest.read(table)[0], "off")
    (step,) = batch.steps("synth", batch.units)
    good, changed = (tmp_path / name).read_bytes(), tmp_path / name
    change(changed)
    with pytest.raises(S2agError, match="changed while it was read"):
        tasks.Synthesis()(step.task.params, lambda stage, share: None)
    changed.write_bytes(good)
    (step,) = batch.steps("synth", batch.units)
    assert step.state == "ready" and not list((tmp_path / "out").rglob("a.*"))


def test_a_result_that_is_deleted_before_its_record_is_not_believed_to_be_there(tmp_path):
    record = Folder(tmp_path).record("synth", "a")
    with pytest.raises(S2agError, match="npz/a.npz was deleted while a was made"):
        record.write("key", [tmp_path / "npz" / "a.npz"], {})
    assert record.read("key") is None
    (tmp_path / "npz").mkdir()
    (tmp_path / "npz" / "a.npz").write_bytes(b"1")
    record.write("key", [tmp_path / "npz" / "a.npz"], {"one": 1})
    assert record.read("key") == {"one": 1}
