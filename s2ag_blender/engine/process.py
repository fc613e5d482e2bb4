"""The engine as a child process, with a thread for each of its three pipes, so that no call blocks."""

import contextlib
import queue
import subprocess
import threading
from collections import deque

from ...core import child_process
from ...core.errors import S2agError, WorkerFailed
from ...core.worker import interpreter, protocol

GRACE = 10.0
"""Seconds that a cancelled request or a closing worker gets before its process is killed."""

_ENVIRONMENT = {"MALLOC_ARENA_MAX": "1"}
"""Variable of the GNU C library: one arena for all threads saves 100 MB after a few minutes of speech."""


class Process:
    """A worker process. ``inbox`` gets lines of its output as bytes, lines of its log as text, and None at the end.

    Raises :class:`WorkerFailed` if it cannot be started."""

    def __init__(self, command: list[str]) -> None:
        environment = {**_ENVIRONMENT, **child_process.environment()}
        try:  # in a process group of its own, so that Ctrl-C in a terminal reaches the client only
            self._popen = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                **child_process.own_group_options(),
            )
        except OSError as error:
            raise WorkerFailed(f"The engine cannot be started: {error.strerror}.", f"Check that {command[0]} runs.") from error
        self.inbox: queue.SimpleQueue[bytes | str | None] = queue.SimpleQueue()
        self._outbox: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._log: deque[str] = deque(maxlen=40)
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._read, self._read_log, self._write)]
        for thread in reversed(self._threads):  # the first one joins the second, which must have been started by then
            thread.start()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._popen.pid

    def send(self, message: dict) -> None:
        """Queue a message of the protocol; never waits."""
        self._outbox.put(protocol.encode(message))

    def epitaph(self) -> str:
        """Return one sentence on how the process ended."""
        code = self._popen.poll()
        if code is None:
            return "The engine closed its output."
        return f"The engine was killed by signal {-code}." if code < 0 else f"The engine ended with status {code}."

    def start_error(self) -> S2agError | None:
        """Return why the Python did not start its package, if the log says so."""
        return interpreter.start_error(self._log)

    def advice(self) -> str:
        """Return a remedy if the log says that a package is missing, else an empty text."""
        missing = next((line for line in self._log if line.startswith(("ModuleNotFoundError", "ImportError"))), "")
        return f"Its Python lacks something ({missing.strip()}); install s2ag[full] there." if missing else ""

    def end(self) -> None:
        """Request a shutdown; kill the process if it does not end within :data:`GRACE` seconds."""
        self.send({"method": "shutdown"})
        self._outbox.put(None)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(GRACE)
        self.kill()

    def kill(self) -> None:
        """Kill the process and wait for its end."""
        self._outbox.put(None)
        self._popen.kill()
        self._popen.wait()
        for thread in self._threads:
            thread.join(0.2)

    def _read(self) -> None:
        assert self._popen.stdout is not None
        with self._popen.stdout as pipe:
            for line in pipe:
                if line.strip():
                    self.inbox.put(line)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(1.0)
        self._threads[1].join(1.0)  # the log explains the end, so it must be in the inbox before
        self.inbox.put(None)

    def _read_log(self) -> None:
        assert self._popen.stderr is not None
        with self._popen.stderr as pipe:
            for line in pipe:
                text = line.decode("utf-8", "replace").rstrip()
                self._log.append(text)
                self.inbox.put(text)

    def _write(self) -> None:
        assert self._popen.stdin is not None
        with contextlib.suppress(OSError, ValueError), self._popen.stdin as pipe:
            while (line := self._outbox.get()) is not None:
                pipe.write(line)
                pipe.flush()
