"""Files appear whole or not at all, and what a killed process left is removed by the next."""

import os
import subprocess
import sys

import pytest
from s2ag.core import files

LEAVES = """
import os, sys
from s2ag.core import files
with files.atomic_file(sys.argv[1]) as temporary, files.temporary_folder(os.path.dirname(sys.argv[1])) as folder:
    temporary.write_text("half")
    (folder / "1.png").write_text("half")
    os._exit(1)
"""


def test_what_a_killed_process_left_is_removed_by_the_next_run(tmp_path):
    path = tmp_path / "a {x}.txt"
    subprocess.run([sys.executable, "-c", LEAVES, str(path)], check=False)
    assert len(list(tmp_path.iterdir())) == 4  # each with its lock
    elsewhere = tmp_path / f"{files.TEMPORARY_PREFIX}another-machine@1@x.txt"
    elsewhere.write_text("still at it")
    with files.atomic_file(path) as temporary, files.temporary_folder(tmp_path) as folder:
        there = {one.name for one in tmp_path.iterdir() if one.suffix != ".lock"}
        assert there == {temporary.name, folder.name, elsewhere.name}
        assert "{" not in temporary.name
        files.delete_leftovers(tmp_path)
        temporary.write_text("whole")
    assert {one.name for one in tmp_path.iterdir()} == {path.name, elsewhere.name} and path.read_text() == "whole"


STAYS = """
import os, sys
from pathlib import Path
from s2ag.core import files
os.getpid = lambda: 2**22 + 1
with files.atomic_file(sys.argv[1]) as temporary, files.temporary_folder(os.path.dirname(sys.argv[1])) as folder:
    temporary.write_text("half")
    print("at it", flush=True)
    sys.stdin.read()
    temporary.with_suffix(".new").write_text("whole")
    os.replace(temporary.with_suffix(".new"), temporary)
    (folder / "1.png").write_text("whole")
"""


@pytest.mark.parametrize("apart", [[], ["unshare", "--user", "--map-root-user", "--pid", "--fork"]], ids=["id", "namespace"])
def test_files_of_a_living_process_whose_id_nobody_knows_stay(tmp_path, apart):
    """Containers on one share have the same host name and do not see each other's processes."""
    if apart and subprocess.run([*apart, "true"], capture_output=True).returncode:
        pytest.skip("processes cannot be put apart here")
    command, pipes = [*apart, sys.executable, "-c", STAYS, str(tmp_path / "film.mp4")], {"stdin": -1, "stdout": -1}
    with subprocess.Popen(command, **pipes, text=True) as other:
        assert other.stdout.readline() == "at it\n"
        files.delete_leftovers(tmp_path)
        assert len(list(tmp_path.iterdir())) == 4
        other.communicate("")
    assert other.returncode == 0 and [one.name for one in tmp_path.iterdir()] == ["film.mp4"]
    assert (tmp_path / "film.mp4").read_text() == "whole"


SWAPS = """
import os, sys
from s2ag.core import files
def swap(event, given):
    if event == "open" and given[0] == sys.argv[1] and os.path.isfile(sys.argv[1]):
        os.unlink(sys.argv[1])
        os.mkfifo(sys.argv[1])
sys.addaudithook(swap)
print(files.read_bytes(sys.argv[1]))
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such pipes in folders")
def test_a_file_that_becomes_a_pipe_while_it_is_opened_is_not_waited_for(tmp_path):
    (tmp_path / "a.wav").write_text("sound")
    done = subprocess.run([sys.executable, "-c", SWAPS, str(tmp_path / "a.wav")], capture_output=True, text=True, timeout=60)
    assert done.stdout == "b''\n", done.stderr


def test_nothing_unfinished_stays(tmp_path):
    with pytest.raises(ZeroDivisionError), files.atomic_file(tmp_path / "a.txt"), files.temporary_folder(tmp_path):
        print(1 / 0)
    assert not list(tmp_path.iterdir())


def test_a_folder_is_looked_through_once(tmp_path):
    """A batch writes thousands of files into one: a look through it for each would take the square of them."""
    left = tmp_path / f"{files.TEMPORARY_PREFIX}{files.host_name()}@{2**22 + 1}@x.txt"
    for there in (True, False):
        left.write_text("half")
        files.delete_leftovers(tmp_path)
        assert left.exists() is not there


def test_a_number_that_is_no_process_stays(tmp_path):
    left = tmp_path / f"{files.TEMPORARY_PREFIX}{files.host_name()}@²@x"
    left.touch()
    with files.atomic_file(tmp_path / "a.txt") as temporary:
        temporary.write_text("a")
    assert left.exists() and (tmp_path / "a.txt").read_text() == "a"
