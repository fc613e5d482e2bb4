"""A program of our own in a process of its own: what can crash or hang does so there, and here it is one sentence."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable

from .files import abandon

HELD = "S2AG_HELD"
"""Environment variable of a child whose parent holds its standard input open: a folder that goes with the parent, or ""."""


_folder = ""


def hold_on() -> None:
    """In a child: end at once when the parent is gone, wherever the main thread is, and leave nothing unfinished behind."""
    global _folder
    folder = os.environ.pop(HELD, None)
    if folder is not None:
        _folder = folder
        threading.Thread(target=_listen, daemon=True).start()


def leave() -> None:
    """End this process at once, because nobody waits for its work, and leave nothing unfinished behind."""
    abandon()
    if _folder:
        shutil.rmtree(_folder, ignore_errors=True)
    os._exit(1)


def _listen() -> None:
    with contextlib.suppress(OSError):
        while os.read(0, 4096):
            pass
    leave()


class ChildFailed(Exception):
    """The child gave no usable answer; the text completes "It ..."."""


def apart() -> dict:
    """Arguments of :class:`subprocess.Popen` for a child in a group of its own, which a terminal's Ctrl-C does not reach."""
    if os.name == "nt":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"start_new_session": True}


def end(process: subprocess.Popen) -> None:
    """Kill a child that was started :func:`apart`, and what it has started itself."""
    if process.returncode is not None:
        return  # it was waited for, so its number may be another's by now
    if os.name == "nt":
        command = ["taskkill", "/F", "/T", "/PID", str(process.pid)]
        subprocess.run(command, capture_output=True, creationflags=subprocess.CREATE_NO_WINDOW)
    else:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


class Reserve:
    """At most one child that is started before it is asked, since a Python with numpy takes some tenths of a second to start.

    It waits for its request; it has to end by itself where that never comes, for its input ends when this process does.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._command: list[str] = []
        self._child: subprocess.Popen | None = None

    def start(self, command: list[str]) -> None:
        """Have a child of this command wait, if none does yet; one that cannot be started is missed when it is asked."""
        with self._lock, contextlib.suppress(OSError):
            if not self._waits(command):
                self._drop()
                self._command, self._child = command, _started(command)

    def take(self, command: list[str]) -> subprocess.Popen:
        """The child that waits, or a new one; raises OSError."""
        with self._lock:
            if not self._waits(command):
                self._drop()
                return _started(command)
            child, self._child = self._child, None
            return child

    def _waits(self, command: list[str]) -> bool:
        return self._child is not None and self._command == command and self._child.poll() is None

    def _drop(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.wait()
            for pipe in (child.stdin, child.stdout):
                pipe.close()


def ask(
    command: list[str],
    request: dict,
    data: Iterable[bytes],
    limit: float,
    hear: Callable[[dict], object | None],
    reserve: Reserve | None = None,
):
    """Send a line of JSON and then ``data``; hand every answering line to ``hear`` until it returns something; return that.

    ``hear`` may raise anything: the child is stopped and the exception passed on; ValueError, KeyError, TypeError and
    IndexError mean nonsense. The child is killed after ``limit`` seconds. Where a ``reserve`` has one waiting, that is asked.
    Raises :class:`ChildFailed`.
    """
    try:
        child = (reserve or Reserve()).take(command)
    except OSError as error:
        raise ChildFailed("could not be started") from error
    late = threading.Event()
    alarm = threading.Timer(limit, lambda: (late.set(), child.kill()))
    alarm.daemon = True
    alarm.start()
    feeder = threading.Thread(target=_feed, args=(child.stdin, request, data), daemon=True)
    feeder.start()
    try:
        for line in child.stdout:
            result = _heard(line, hear)
            if result is not None:
                return result
    finally:
        alarm.cancel()
        child.kill()
        child.wait()
        feeder.join()
        child.stdout.close()
    raise ChildFailed("took too long" if late.is_set() else "died")


def _started(command: list[str]) -> subprocess.Popen:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


def _heard(line: bytes, hear):
    try:
        return hear(json.loads(line))
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ChildFailed("answered nonsense") from error


def _feed(pipe, request: dict, data: Iterable[bytes]) -> None:
    try:
        with pipe:
            pipe.write(json.dumps(request).encode() + b"\n")
            for piece in data:
                pipe.write(piece)
    except OSError:
        return  # the child is gone; its reader notices
