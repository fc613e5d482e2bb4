"""A crew survives what its tasks do, and leaves nobody behind."""

import os
import subprocess
import sys
import threading
import time

import pytest
from s2ag.core.batch import process_pool
from s2ag.core.errors import S2agError

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX")

CHILD = """
import os, sys, time
from s2ag.core.batch import child_server
from s2ag.core.errors import UsageError
def work(params, tell):
    tell("half", 0.5)
    if params["do"] == "die": os._exit(9)
    if params["do"] == "hang": time.sleep(60)
    if params["do"] == "start":
        import subprocess
        process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
        open(params["mark"], "w").write(str(process.pid))
        process.wait()
    if params["do"] == "refuse": raise UsageError("No.", "Never.")
    if params["do"] == "full": raise OSError(28, "No space left on device", "/out/a.npz")
    if params["do"] == "break": raise ZeroDivisionError("oh")
    if params["do"] == "once" and not os.path.exists(params["mark"]):
        open(params["mark"], "w").close()
        os.kill(os.getpid(), 9)
    print("chatter on standard output")
    return {"done": params["do"], "pid": os.getpid()}
sys.exit(child_server.serve({"work": work}))
"""


def done(tasks, size=2, patience=60.0):
    """Outcome of each task by what it does."""
    found = {}
    for task, outcome, share in process_pool.ProcessPool([sys.executable, "-c", CHILD], size, patience).run(tasks):
        if outcome is None:
            assert share == 0.5
        else:
            found[task.params["do"]] = outcome
    return found


def test_a_crew_survives_what_its_tasks_do(tmp_path):
    tasks = [
        process_pool.Task("work", {"do": do, "mark": str(tmp_path / "mark")})
        for do in ("a", "die", "refuse", "break", "full", "once", "b")
    ]
    found = done(tasks)
    assert found["a"]["done"] == "a" and found["b"]["done"] == "b" and found["once"]["done"] == "once"
    assert found["refuse"].kind == "UsageError" and found["refuse"].remedy == "Never."
    assert "status 9" in found["die"].message and found["die"].kind == "WorkerFailed"
    assert found["full"].kind == "OutputUnwritable" and "/out/a.npz failed: No space left on device." in found["full"].message
    assert found["break"].kind == "Internal" and "ZeroDivisionError: oh" in found["break"].message


def test_a_silent_process_is_ended():
    found = done([process_pool.Task("work", {"do": "hang"}), process_pool.Task("work", {"do": "a"})], size=1, patience=2.0)
    assert "silent" in found["hang"].message and found["a"]["done"] == "a"


def test_processes_are_kept_for_many_tasks():
    one = process_pool.ProcessPool([sys.executable, "-c", CHILD], 2)
    pids = {
        outcome["pid"] for _, outcome, _ in one.run([process_pool.Task("work", {"do": str(n)}) for n in range(12)]) if outcome
    }
    assert 1 <= len(pids) <= 2
    assert list(one.run([])) == []


def test_a_crew_that_is_abandoned_leaves_nobody():
    running = process_pool.ProcessPool([sys.executable, "-c", CHILD], 1).run(
        [process_pool.Task("work", {"do": do}) for do in ("a", "hang")]
    )
    pid = next(outcome["pid"] for _, outcome, _ in running if outcome)
    running.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@posix
def test_what_a_task_has_started_ends_with_it(tmp_path):
    tasks = [process_pool.Task("work", {"do": "start", "mark": str(tmp_path / "pid")})]
    running = process_pool.ProcessPool([sys.executable, "-c", CHILD], 1).run(tasks)
    next(running)
    while not (tmp_path / "pid").is_file() or not (tmp_path / "pid").read_text():
        time.sleep(0.05)
    pid = int((tmp_path / "pid").read_text())
    os.kill(pid, 0)
    running.close()
    deadline = time.monotonic() + 20
    while is_alive(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_alive(pid)


def is_alive(pid):
    """Whether a process runs; one that has ended and is waited for by nobody does not."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = f"/proc/{pid}/stat"
    return not os.path.exists(status) or open(status).read().rpartition(")")[2].split()[0] != "Z"


def test_a_program_that_cannot_run_is_one_error_each():
    found = [outcome for _, outcome, _ in process_pool.ProcessPool(["/no/such/program"], 1).run([process_pool.Task("x", {})])]
    assert isinstance(found[0], S2agError) and "/no/such/program" in found[0].message


def test_no_process_is_started_once_the_end_has_begun(monkeypatch):
    """Between two tasks the member's thread sees its process dead, which the end of the crew has just killed."""
    between, killed = threading.Event(), threading.Event()
    main = threading.current_thread()

    class Watched(subprocess.Popen):
        def poll(self):
            if threading.current_thread() is not main:
                between.set()
                killed.wait(process_pool.LAST_WAIT)
            return super().poll()

    def end(process):
        real_end(process)
        process.wait()
        killed.set()

    real_end = process_pool.child_process.kill_tree
    monkeypatch.setattr(process_pool.subprocess, "Popen", Watched)
    monkeypatch.setattr(process_pool.child_process, "kill_tree", end)
    running = process_pool.ProcessPool([sys.executable, "-c", CHILD], 1).run(
        [process_pool.Task("work", {"do": do}) for do in ("a", "hang")]
    )
    next(outcome for _, outcome, _ in running if outcome)
    assert between.wait(process_pool.LAST_WAIT)
    began = time.monotonic()
    running.close()
    assert time.monotonic() - began < process_pool.LAST_WAIT


@posix
def test_hundreds_of_abandoned_crews_leave_nobody():
    """Ended at every moment of a short life: before, between and after tasks."""
    program = 'import sys\nfor line in sys.stdin: print(\'{"id": 0, "result": {}}\', flush=True)'
    started = []
    for number in range(200):
        running = process_pool.ProcessPool([sys.executable, "-S", "-c", program], 1).run(
            [process_pool.Task("work", {}) for _ in range(3)]
        )
        for _ in range(number % 4):
            next(running, None)
        started.append(time.monotonic())
        running.close()
        assert time.monotonic() - started[-1] < process_pool.LAST_WAIT
    assert not [thread for thread in threading.enumerate() if thread.name.endswith("(_work)") and thread.is_alive()]
