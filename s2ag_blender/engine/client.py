"""Client of the worker process: starts it, sends requests without blocking, and handles its crashes.

Imports neither Blender nor torch. Modal operators call :meth:`WorkerClient.request` and then :meth:`Job.poll` from
their timers; headless code calls :meth:`WorkerClient.call`, which waits. Use a client from one thread only."""

import itertools
import os
import queue
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self, cast

from ...core.errors import Cancelled, S2agError, WorkerFailed
from ...core.settings import Models, Settings, table
from ...core.start import module_command, package_command
from ...core.worker import interpreter, protocol
from .process import GRACE, Process
from .thread import Thread

PATIENCE = 300.0
"""Seconds without a message from a busy worker after which it counts as hung."""
PAUSE = 0.02
"""Seconds between polls while waiting."""

_PATHS = {"audio", "output_dir"}
_PATHS |= {name for name, one in {**table(Settings), **table(Models)}.items() if one.kind == "path"}
_AGAIN = "Try again: it starts anew by itself."


def find_interpreter(python: str | os.PathLike | None = None) -> str:
    """Return the Python that runs the worker: ``python``, else ``$S2AG_PYTHON``, else this one, as numpy is enough.

    Raises :class:`WorkerFailed` if the named one cannot be run, or if this one is embedded and has no executable."""
    named = os.fspath(python) if python else os.environ.get("S2AG_PYTHON", "")
    if named:
        executable = shutil.which(named)
        if not executable:
            raise WorkerFailed(
                f"The Python interpreter {named} cannot be run.", "Name the python of an environment with s2ag[full]."
            )
        return executable
    if Path(sys.executable or "").stem.lower().startswith("python"):
        return sys.executable
    raise WorkerFailed("Blender's own Python cannot be started.", "Name another one in the preferences or in S2AG_PYTHON.")


def engine_command(module: str, python: str | os.PathLike | None = None) -> list[str]:
    """Return the command that runs ``module`` in the engine's Python (:func:`find_interpreter`).

    A Python that was chosen runs its installed package, this one the code of this tree. Raises :class:`WorkerFailed`."""
    executable = find_interpreter(python)
    return package_command(executable, module) if is_chosen(python) else module_command(module)


def is_chosen(python: str | os.PathLike | None = None) -> bool:
    """Return whether ``python`` or ``$S2AG_PYTHON`` names the engine's Python, which then is not the one of the extension."""
    return bool(python or os.environ.get("S2AG_PYTHON"))


class Job:
    """A request that was sent. After :meth:`poll` returned True, :meth:`outcome` returns its result or raises its error."""

    def __init__(self, client: "WorkerClient", number: int, method: str) -> None:
        self._client = client
        self.id = number
        self.method = method
        self.stage = ""
        self.value = 0.0
        self.result: dict | None = None
        self.error: S2agError | None = None
        self.cancelled_at: float | None = None
        self.message: dict = {}

    @property
    def done(self) -> bool:
        """Whether the reply has arrived; does not read new messages."""
        return self.result is not None or self.error is not None

    def poll(self) -> bool:
        """Read the worker's messages without waiting, which updates ``stage`` and ``value`` (0..1); return :attr:`done`."""
        self._client.pump()
        return self.done

    def outcome(self) -> dict:
        """Return the result; raise the :class:`S2agError` that the request ended with."""
        if self.error is not None:
            raise self.error
        assert self.result is not None
        return self.result


class WorkerClient:
    """Owns at most one worker process, which it starts with the first request and restarts after a crash.

    ``python`` is an interpreter (:func:`find_interpreter`), ``log`` a callable that gets each line of the worker's log,
    ``patience`` the seconds of silence after which a busy worker counts as hung, ``command`` replaces the whole command."""

    def __init__(
        self, python: str | os.PathLike | None = None, log: Callable[[str], None] | None = None, patience: float = PATIENCE,
        command: list[str] | None = None
    ) -> None:  # fmt: skip
        self._python = python
        self._log = log
        self._patience = patience
        self._command = command
        self._process: Process | Thread | None = None
        self.ships = not (command or is_chosen(python))
        """Whether it is the engine that comes with the extension, in this Python."""
        self._numbers = itertools.count(1)
        self._jobs: dict[int, Job] = {}
        self._version_check: Job | None = None
        self._last_message = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def pid(self) -> int | None:
        """Process id of the worker, or None while there is none."""
        return self._process and self._process.pid

    @property
    def inside(self) -> bool:
        """Whether the engine runs in a thread of this process, because no other process can be started."""
        return isinstance(self._process, Thread)

    def request(self, method: str, params: dict | None = None) -> Job:
        """Send a request and return at once; raises :class:`WorkerFailed` if no worker can be started."""
        self.pump()
        is_new = self._process is None
        if self._process is None:
            self._process = self._start()
        if not self._jobs:
            self._last_message = time.monotonic()
        if is_new and not (self.ships or self._command):
            self._version_check = self._send("hello", {})
        return self._send(method, params or {})

    def _send(self, method: str, params: dict) -> Job:
        """Send a request to the running worker."""
        assert self._process is not None
        job = Job(self, next(self._numbers), method)
        self._jobs[job.id] = job
        # The worker has a working directory of its own, so send absolute paths.
        sent = {name: os.path.abspath(value) if name in _PATHS and value else value for name, value in params.items()}
        job.message = {"id": job.id, "method": method, "params": sent}
        self._process.send(job.message)
        return job

    def call(
        self, method: str, params: dict | None = None, progress: Callable[[str, float], None] | None = None,
        timeout: float | None = None
    ) -> dict:  # fmt: skip
        """Send a request, wait, and return its result or raise its error.

        ``progress(stage, value)`` is called with the worker's progress. ``timeout`` limits the seconds between messages, not
        those of the whole request. Ctrl-C cancels the request and is then passed on."""
        patience = self._patience
        self._patience = timeout or patience
        try:
            job = self.request(method, params)
            reported = None
            while not job.poll():
                if progress and job.stage and (job.stage, job.value) != reported:
                    reported = (job.stage, job.value)
                    progress(*reported)
                time.sleep(PAUSE)
        except KeyboardInterrupt:
            self._abandon()
            raise
        finally:
            self._patience = patience
        return job.outcome()

    def cancel(self, job: Job) -> None:
        """Tell the worker to cancel ``job``, which then ends with :class:`Cancelled`; kill a worker that does not react.

        A job queued behind another ends at once, because the worker serves one request at a time."""
        if not job.done and job.cancelled_at is None:
            job.cancelled_at = time.monotonic()
            if self._process is not None:
                self._process.send({"method": "cancel", "id": job.id})
            if job.id != min(self._jobs):
                del self._jobs[job.id]
                job.error = Cancelled("Cancelled.")

    def pump(self) -> None:
        """Process all messages that have arrived, and detect a worker that died or hangs. Never waits."""
        process = self._process
        while process is not None and process is self._process:
            try:
                message = process.inbox.get_nowait()
            except queue.Empty:
                break
            self._receive(process, message)
        if self._jobs:
            self._check_silence()

    def close(self) -> None:
        """End the worker; unfinished jobs end with :class:`Cancelled`. Deletes its result files unless they were moved."""
        process, self._process = self._process, None
        self._fail_all(Cancelled("Cancelled."))
        if process:
            process.end()

    def _start(self) -> Process | Thread:
        """Start a worker; the extension's own engine runs in a thread where no process can be started."""
        try:
            return Process(self._command or engine_command("core.worker.server", self._python))
        except WorkerFailed as error:
            if not self.ships:
                raise
            if self._log:
                self._log(f"{error} The engine runs in a thread of Blender's own process.")
            return Thread()

    def _receive(self, process: Process | Thread, message: bytes | str | None) -> None:
        """Handle an item of the inbox: bytes are a line of the protocol, text is a line of the log, None the end."""
        if message is None:
            self._lose(process.epitaph())
        elif isinstance(message, str):
            if self._log:
                self._log(message)
        else:
            self._last_message = time.monotonic()
            try:
                self._dispatch(protocol.decode(message))
            except (protocol.NotProtocol, TypeError, ValueError):
                self._lose(f"The engine talks nonsense ({message[:40].decode('ascii', 'replace').strip()}).")

    def _dispatch(self, message: dict) -> None:
        """Store a message of the worker in its job; raise ValueError or TypeError if it breaks the protocol."""
        job = self._jobs.get(cast(int, message.get("id")))
        if "error" in message:
            error = protocol.to_exception(message["error"])
            if job is None and message.get("id") is None:
                raise ValueError("the worker did not understand a request")
            if job is not None:
                del self._jobs[job.id]
                job.error = error
        elif "result" in message:
            if not isinstance(message["result"], dict):
                raise TypeError("a result must be an object")
            if job is not None:
                del self._jobs[job.id]
                job.result = message["result"]
                if job is self._version_check:
                    self._compare_version(message["result"])
        elif message.get("event") == "progress":
            if job is not None:
                job.stage, job.value = str(message["stage"]) if "stage" in message else "", float(message.get("value", 0))
        else:
            raise ValueError("neither event, result nor error")

    def _check_silence(self) -> None:
        """Kill a worker that does not react to a cancellation or has been silent for too long."""
        now = time.monotonic()
        if any(job.cancelled_at is not None and now - job.cancelled_at > GRACE for job in self._jobs.values()):
            waiting = {number: job for number, job in self._jobs.items() if job.cancelled_at is None}
            self._jobs = {number: job for number, job in self._jobs.items() if number not in waiting}
            self._lose("The engine did not react to the cancellation.")
            self._ask_anew(waiting)
        elif now - self._last_message > self._patience:
            self._lose(f"The engine has not said a word for {self._patience:g} seconds.")

    def _ask_anew(self, waiting: dict[int, Job]) -> None:
        """Ask a new worker for the jobs that waited behind one that was cancelled in vain."""
        if waiting:
            self._process, self._jobs, self._last_message = self._start(), waiting, time.monotonic()
            for job in waiting.values():
                self._process.send(job.message)

    def _compare_version(self, hello: dict) -> None:
        """End a worker of another version than this code."""
        try:
            interpreter.require_version(str(hello.get("version", "")))
        except S2agError as error:
            self._lose("", error)

    def _lose(self, message: str, error: S2agError | None = None) -> None:
        """Kill the worker and let all jobs fail with ``message`` and its remedy, or with ``error``."""
        process, self._process = self._process, None
        assert process is not None
        process.kill()
        self._fail_all(error or process.start_error() or WorkerFailed(message, process.advice() or _AGAIN))

    def _fail_all(self, error: S2agError) -> None:
        jobs, self._jobs = self._jobs, {}
        for job in jobs.values():
            job.error = error if job.cancelled_at is None else Cancelled("Cancelled.")

    def _abandon(self) -> None:
        """Cancel all jobs and wait for their end, at most :data:`GRACE` seconds."""
        for job in list(self._jobs.values()):
            self.cancel(job)
        while self._jobs:
            self.pump()
            time.sleep(PAUSE)
