"""A command that is killed takes its Blender with it, whatever that is doing, and nothing of theirs stays."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from s2ag.core.files import delete_leftovers
from s2ag.core.locks import is_held

pytestmark = pytest.mark.slow

STARTER = """
import sys, tempfile
from pathlib import Path
from s2ag.core.cli import blender

with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
    job = Path(folder) / "job.json"
    job.write_text(sys.argv[1])
    print(folder, flush=True)
    blender.run("render.job", str(job), progress=lambda stage, value: print(stage, value, flush=True), talk="all")
"""


MOMENTS = ("character 0", "keyframes 0", "stage 1", "write take.####.png 0", "write take.####.png 0.5")
MORE = ("character 1", "stage 0", "write take.####.png 0.02", "write take.####.png 0.2")
KILLS = [
    *((moment, signal.SIGKILL) for moment in MOMENTS),
    ("write take.####.png 0", signal.SIGTERM),
    *(pytest.param(moment, signal.SIGKILL, marks=pytest.mark.slow) for moment in MORE),
]


@pytest.mark.parametrize(("moment", "number"), KILLS)
def test_a_killed_command_leaves_no_process_and_no_part(tmp_path, wave, moment, number):
    """Whoever holds the pipe lives: the command, and the Blender that writes its chatter to the same place."""
    motion, out = tmp_path / "motion.npz", tmp_path / "out"
    out.mkdir()
    wave(400).save(motion)
    content = {"motions": [str(motion)], "character": "mannequin", "resolution": [16, 16], "engine": "cycles", "samples": 1}
    content["outputs"] = [str(out / "take.####.png")]
    ours, theirs = os.pipe()
    command = [sys.executable, "-c", STARTER, json.dumps(content)]
    starter = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, text=True)
    os.close(theirs)
    ended = threading.Event()
    threading.Thread(target=_drain, args=(ours, ended), daemon=True).start()
    folder = starter.stdout.readline().strip()
    for line in starter.stdout:
        stage, _, value = line.rpartition(" ")
        if stage == moment.rpartition(" ")[0] and float(value) >= float(moment.rpartition(" ")[2]):
            break
    else:
        pytest.fail("the moment never came")
    starter.send_signal(number)
    starter.wait(120)
    assert ended.wait(300), "Blender outlives its command"
    # a thread that was writing when all ended may have left a file, which goes with the next run
    until = time.monotonic() + 60
    while any(is_held(out / name) for name in _parts(out)) and time.monotonic() < until:
        time.sleep(0.1)
    delete_leftovers(out)
    assert not _parts(out)
    assert not os.path.exists(folder)
    starter.stdout.close()


def _parts(folder):
    return [path.name for path in folder.iterdir() if path.name.startswith(".")]


def _drain(pipe, ended):
    with contextlib.closing(os.fdopen(pipe, "rb")) as chatter:
        while chatter.read1(65536):
            pass
    ended.set()
