"""The engine's process: three pipes, a thread for each, and never a wait."""

import contextlib
import os
import queue
import subprocess
import threading
from collections import deque

from ...core import child
from ...core.engine import protocol
from ...core.errors import WorkerFailed

GRACE = 10.0
"""Seconds that a cancelled request or a closing worker gets before its process is killed."""

_FRUGAL = {"MALLOC_ARENA_MAX": "1"}
"""A variable of the C library on Linux: without it every thread keeps to itself what it was given, and a worker that has heard
a few minutes of speech holds 100 MB more."""


class Process:
    """A worker process with a thread for each of its three pipes, so that nobody ever waits for a pipe."""

    def __init__(self, command: list[str]):
        environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONSAFEPATH")}
        environment = {**_FRUGAL, **environment}
        # A terminal's Ctrl-C goes to the whole group: the client decides what it means, not the worker.
        try:
            self._popen = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                **child.apart(),
            )
        except OSError as error:
            raise WorkerFailed(f"The engine cannot be started: {error.strerror}.", f"Check that {command[0]} runs.") from error
        self.inbox: queue.SimpleQueue = queue.SimpleQueue()
        self._outbox: queue.SimpleQueue = queue.SimpleQueue()
        self._said: deque[str] = deque(maxlen=40)
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._hear, self._read_log, self._write)]
        for thread in reversed(self._threads):  # the first one joins the second, which must have been started by then
            thread.start()

    @property
    def pid(self) -> int:
        return self._popen.pid

    def send(self, message: dict) -> None:
        self._outbox.put(protocol.encode(message))

    def epitaph(self) -> str:
        """One sentence on how the process ended."""
        code = self._popen.poll()
        if code is None:
            return "The engine closed its output."
        return f"The engine was killed by signal {-code}." if code < 0 else f"The engine ended with status {code}."

    def advice(self) -> str:
        """What the log suggests, when the worker could not even import itself."""
        missing = next((line for line in self._said if line.startswith(("ModuleNotFoundError", "ImportError"))), "")
        return f"Its Python lacks something ({missing.strip()}); install s2ag[engine] there." if missing else ""

    def end(self) -> None:
        """Ask the process to end, and make sure that it does."""
        self.send({"method": "shutdown"})
        self._outbox.put(None)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(GRACE)
        self.kill()

    def kill(self) -> None:
        self._outbox.put(None)
        self._popen.kill()
        self._popen.wait()
        for thread in self._threads:
            thread.join(0.2)

    def _hear(self) -> None:
        with self._popen.stdout as pipe:
            for line in pipe:
                if line.strip():
                    self.inbox.put(line)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(1.0)
        self._threads[1].join(1.0)  # the log explains the end, so it comes first
        self.inbox.put(None)

    def _read_log(self) -> None:
        with self._popen.stderr as pipe:
            for line in pipe:
                text = line.decode("utf-8", "replace").rstrip()
                self._said.append(text)
                self.inbox.put(text)

    def _write(self) -> None:
        with contextlib.suppress(OSError, ValueError), self._popen.stdin as pipe:
            while (line := self._outbox.get()) is not None:
                pipe.write(line)
                pipe.flush()
