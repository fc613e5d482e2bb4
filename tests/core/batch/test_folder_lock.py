"""Two batches on one folder: the second is told so, whatever happened to the first its locks go with it."""

import json
import os
import subprocess
import sys

import pytest
from refusals import one_sentence
from s2ag.core.batch.folder_lock import lock_clips
from s2ag.core.cli.main import main
from s2ag.core.errors import OutputUnwritable
from sounds import write_wav

HOLD = """
import sys
from pathlib import Path
from s2ag.core.batch.folder_lock import lock_clips

with lock_clips(Path(sys.argv[1]), ["synth"], sys.argv[2:]):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def hold(tmp_path):
    """Starts a process that holds clips of the folder."""
    started = []

    def start(*names):
        command = [sys.executable, "-c", HOLD, str(tmp_path), *names]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout.readline() == "held\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def test_the_second_is_refused_and_others_clips_and_stages_are_free(hold, tmp_path):
    first = hold("a", "b")
    with pytest.raises(OutputUnwritable, match=f"process {first.pid} "), lock_clips(tmp_path, ["synth", "render"], ["b", "c"]):
        pytest.fail("two at work")
    with lock_clips(tmp_path, ["synth"], ["c"]), lock_clips(tmp_path, ["render"], ["a"]):
        pass
    first.communicate("")
    with lock_clips(tmp_path, ["synth"], ["a"]):
        assert len(list((tmp_path / ".locks").glob("*.json"))) == 1
    assert not list((tmp_path / ".locks").glob("*.json"))


def test_a_killed_process_holds_nothing(hold, tmp_path):
    first = hold("a")
    first.kill()
    first.wait()
    assert list((tmp_path / ".locks").glob("*.json"))
    with lock_clips(tmp_path, ["synth"], ["a"]):
        pass
    assert not list((tmp_path / ".locks").glob("*.json"))


@pytest.mark.parametrize("content", ["", "[]", "{", '{"stages": 3, "names": null}', '{"stages": [[]], "names": [{}]}'])
def test_a_lock_that_says_nothing_holds_everything(hold, tmp_path, content):
    hold("a")
    (lock,) = (tmp_path / ".locks").glob("*.json")
    lock.write_text(content)
    with pytest.raises(OutputUnwritable, match="at work"), lock_clips(tmp_path, ["encode"], ["z"]):
        pytest.fail("two at work")


def test_the_command_line_says_it_in_one_sentence(hold, tmp_path, capsys):
    write_wav(tmp_path / "a.wav", [0.1, -0.1] * 16000)
    (tmp_path / "talks.jsonl").write_text(json.dumps({"audio": "a.wav", "name": "a", "no_transcript": True}))
    command = ["batch", "synth", str(tmp_path / "talks.jsonl"), "-o", str(tmp_path), "-j", "1"]
    first = hold("a")
    assert main(command) == 2
    assert "Another s2ag batch is at work" in one_sentence(capsys.readouterr().err)
    assert not (tmp_path / "npz").exists()
    first.communicate("")
    assert main(command) == 0 and os.listdir(tmp_path / "npz") == ["a.npz"]


def test_of_many_that_start_at_once_one_works(tmp_path):
    code = HOLD.replace("sys.stdin.read()", "import time; time.sleep(1.5)")
    commands = [[sys.executable, "-c", code, str(tmp_path), "a"] for _ in range(4)]
    started = [subprocess.Popen(one, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) for one in commands]
    assert sorted(process.communicate()[0] for process in started) == ["", "", "", "held\n"]
