"""Runs helper programs in child processes, so that their crashes and hangs become error messages here."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable
from typing import IO, Any

from .files import delete_unfinished

HELD_VARIABLE = "S2AG_HELD"
"""Environment variable of a child whose parent keeps its standard input open: a folder to delete with the parent, or ""."""
_temporary_folder = ""


def exit_with_parent() -> None:
    """In a child: exit as soon as the parent is gone, even while the main thread is busy; deletes unfinished files."""
    global _temporary_folder
    folder = os.environ.pop(HELD_VARIABLE, None)
    if folder is not None:
        _temporary_folder = folder
        threading.Thread(target=_wait_for_end_of_input, daemon=True).start()


def exit_now() -> None:
    """Exit this process at once, as nobody needs its result; deletes unfinished files."""
    delete_unfinished()
    if _temporary_folder:
        shutil.rmtree(_temporary_folder, ignore_errors=True)
    os._exit(1)


def _wait_for_end_of_input() -> None:
    with contextlib.suppress(OSError):
        while os.read(0, 4096):
            pass
    exit_now()


class ChildFailed(Exception):
    """The child gave no usable answer; the message completes "It ..."."""


def environment() -> dict[str, str]:
    """Return this process's environment variables for another Python, without those that are meant for the running one."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONSAFEPATH")}


def own_group_options() -> dict[str, Any]:
    """Return arguments of :class:`subprocess.Popen` for a child in its own process group, which Ctrl-C does not reach."""
    if os.name == "nt":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"start_new_session": True}


def kill_tree(process: subprocess.Popen) -> None:
    """Kill a child that was started with :func:`own_group_options`, and all its descendants."""
    if process.returncode is not None:
        return  # the process was reaped: its id may belong to another one by now
    if os.name == "nt":
        command = ["taskkill", "/F", "/T", "/PID", str(process.pid)]
        subprocess.run(command, capture_output=True, creationflags=subprocess.CREATE_NO_WINDOW)
    else:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


class StandbyChild:
    """Keeps one child on standby, since starting a Python with numpy takes some tenths of a second.

    The child waits for its request and must exit when its input ends, which happens at the latest when this process does."""

    def __init__(self):
        self._lock = threading.Lock()
        self._command: list[str] = []
        self._child: subprocess.Popen | None = None

    def start(self, command: list[str]) -> None:
        """Start a standby child of this command unless one is waiting; errors are reported by :meth:`take`."""
        with self._lock, contextlib.suppress(OSError):
            if self._waiting(command) is None:
                self._drop()
                self._command, self._child = command, _start(command)

    def take(self, command: list[str]) -> subprocess.Popen:
        """Return the standby child, or a new one; raises OSError."""
        with self._lock:
            child = self._waiting(command)
            if child is None:
                self._drop()
                return _start(command)
            self._child = None
            return child

    def _waiting(self, command: list[str]) -> subprocess.Popen | None:
        if self._child is not None and self._command == command and self._child.poll() is None:
            return self._child
        return None

    def _drop(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.wait()
            for pipe in (child.stdin, child.stdout):
                if pipe is not None:
                    pipe.close()


def run_request(
    command: list[str], request: dict, data: Iterable[bytes], limit: float, hear: Callable[[dict], object | None],
    reserve: StandbyChild | None = None
) -> Any:  # fmt: skip
    """Send a request as a line of JSON, followed by ``data``, and return the child's result.

    Every line of the response goes to ``hear`` until it returns something other than None: the result. ``hear`` may raise:
    the child is stopped and the exception propagates, but ValueError, KeyError, TypeError and IndexError count as an
    invalid response. The child is killed after ``limit`` seconds. Uses the standby child of ``reserve``, if there is one.
    Raises :class:`ChildFailed`."""
    try:
        child = (reserve or StandbyChild()).take(command)
    except OSError as error:
        raise ChildFailed("could not be started") from error
    assert child.stdin is not None and child.stdout is not None
    timed_out = threading.Event()
    timer = threading.Timer(limit, lambda: (timed_out.set(), child.kill()))
    timer.daemon = True
    timer.start()
    feeder = threading.Thread(target=_feed, args=(child.stdin, request, data), daemon=True)
    feeder.start()
    try:
        for line in child.stdout:
            result = _handle(line, hear)
            if result is not None:
                return result
    finally:
        timer.cancel()
        child.kill()
        child.wait()
        feeder.join()
        child.stdout.close()
    raise ChildFailed("took too long" if timed_out.is_set() else "died")


def _start(command: list[str]) -> subprocess.Popen:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


def _handle(line: bytes, hear: Callable[[dict], object | None]) -> object | None:
    try:
        return hear(json.loads(line))
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ChildFailed("answered nonsense") from error


def _feed(pipe: IO[bytes], request: dict, data: Iterable[bytes]) -> None:
    try:
        with pipe:
            pipe.write(json.dumps(request).encode() + b"\n")
            for piece in data:
                pipe.write(piece)
    except OSError:
        return  # the child is gone; the reading thread reports it
