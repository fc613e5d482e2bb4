"""Files and folders that change, vanish or close in the middle of a run, and processes that do not see each other.

``S2AG_FUZZ=50000 pytest tests/fuzz/test_situations.py`` tries a thousand, ``python tests/fuzz/situations.py LOG 1 NUMBER`` one.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("av", reason="the engine is not installed")
if sys.platform != "linux":
    pytest.skip("limits and namespaces are Linux's", allow_module_level=True)

COUNT, FIRST = int(os.environ.get("S2AG_FUZZ", "800")) // 50, int(os.environ.get("S2AG_FUZZ_FIRST", "0"))
HERE = Path(__file__).parent


def tried(log, *numbers):
    """What a process says that tries situations."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), *sys.path]), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, HERE / "situations.py", log, *map(str, numbers)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace")


@pytest.mark.timeout(0 if COUNT > 500 else 300)
def test_every_situation_ends_in_its_result_or_in_two_sentences_and_leaves_nothing(tmp_path):
    log = tmp_path / "log"
    log.write_text(f'{{"next": {FIRST}, "fell": 0, "tried": {{}}}}\n')
    done = tried(log, COUNT)
    assert done.returncode == 0, (done.stdout + done.stderr)[-6000:]
