"""A pool of child processes that share tasks; a task that crashes or hangs its process fails alone."""

import contextlib
import os
import queue
import subprocess
import tempfile
import threading
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from typing import Any

from .. import child_process
from ..errors import S2agError, WorkerFailed
from ..threads import SINGLE_THREAD_ENVIRONMENT
from ..worker import protocol

TRIES = 2
"""Attempts per task: its process may have been killed because another program used too much memory."""
PATIENCE = 1800.0
"""Seconds without a message from a busy process after which it counts as hung."""
LAST_WAIT = 10.0
"""Seconds to wait, at the end, for a thread or a killed process."""


@dataclass(frozen=True)
class Task:
    """A call of the children's ``method`` with ``params`` (JSON); ``label`` is for the caller."""

    method: str
    params: dict
    label: Any = field(default=None, compare=False)


class ProcessPool:
    """``size`` processes of ``command``, which runs :mod:`child_server`; each is started with its first task and then
    reused.
    """

    def __init__(self, command: Sequence[str], size: int, patience: float = PATIENCE):
        self._command, self._size, self._patience = list(command), max(size, 1), patience

    def run(self, tasks: Sequence[Task]) -> Generator[tuple[Task, dict | S2agError | None, float], None, None]:
        """Run all ``tasks``; yield ``(task, result or error, 1)`` as each ends, and ``(task, None, share)`` as progress.

        When the iterator ends or is closed, all processes have ended.
        """
        todo: queue.SimpleQueue = queue.SimpleQueue()
        for task in tasks:
            todo.put(task)
        outcomes: queue.SimpleQueue = queue.SimpleQueue()
        members = [_Member(self._command, todo, outcomes) for _ in range(min(self._size, len(tasks)))]
        try:
            left = len(tasks)
            while left:
                try:
                    task, outcome, share = outcomes.get(timeout=min(1.0, self._patience / 4))
                except queue.Empty:
                    for member in members:
                        member.watch(self._patience)
                    continue
                if isinstance(outcome, BaseException) and not isinstance(outcome, S2agError):
                    raise outcome
                left -= outcome is not None
                yield task, outcome, share
        finally:
            for member in members:
                member.end()


class _Member:
    """One child process and the thread that sends it tasks."""

    def __init__(self, command: list[str], todo: queue.SimpleQueue, outcomes: queue.SimpleQueue):
        self._command, self._todo, self._outcomes = command, todo, outcomes
        self._process: subprocess.Popen | None = None
        self._log = tempfile.TemporaryFile("w+b", buffering=0)  # noqa: SIM115 - closed in end()
        self._ending = self._hung = False
        self._starting = threading.Lock()
        self._last_message: float | None = None  # time of the last sign of life while busy
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def watch(self, patience: float) -> None:
        """Kill a busy process that has been silent for more than ``patience`` seconds."""
        last = self._last_message
        if last is not None and self._process is not None and time.monotonic() - last > patience:
            self._hung = True
            child_process.kill_tree(self._process)

    def end(self) -> None:
        """Kill the process: its current task is not needed, and all finished results are in place."""
        with self._starting:  # no process is started after this
            self._ending = True
        if self._process is not None:
            child_process.kill_tree(self._process)
        self._thread.join(LAST_WAIT)
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):  # the system may be unable to kill it
                self._process.wait(LAST_WAIT)
        self._log.close()

    def _work(self) -> None:
        """Run tasks until none is left; the thread's main function."""
        with contextlib.suppress(queue.Empty):
            while not self._ending:
                task = self._todo.get_nowait()
                try:
                    outcome = self._do(task)
                except Exception as error:  # raised again in the main thread
                    outcome = error
                if not self._ending:
                    self._outcomes.put((task, outcome, 1.0))

    def _do(self, task: Task) -> dict | S2agError:
        """Run a task, up to ``TRIES`` times if its process dies; return its result or error."""
        error: S2agError | None = None
        for _ in range(TRIES):
            if self._ending:
                break
            process = self._process
            if process is None or process.poll() is not None:
                process = self._start()
            if process is None:
                break
            answer = self._request(process, task)
            if answer is not None:
                return answer
            error = self._describe_death(process)
            if self._hung:
                break
        return error or WorkerFailed("The batch was ended.")

    def _start(self) -> subprocess.Popen | None:
        """Start the process; return None if the crew is ending: it waits only for processes it knows of."""
        environment = {
            name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"
        } | SINGLE_THREAD_ENVIRONMENT
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self._log}
        with self._starting:
            if self._ending:
                return None
            self._hung = False
            try:
                # Only the parent handles Ctrl-C and ends its children; a child killed by it would look like a failed clip.
                self._process = subprocess.Popen(self._command, **pipes, env=environment, **child_process.own_group_options())
            except OSError as error:
                what = f"{self._command[0]} cannot be started: {error.strerror}."
                raise WorkerFailed(what, "Check that it runs.") from error
            return self._process

    def _request(self, process: subprocess.Popen, task: Task) -> dict | S2agError | None:
        """Send a task and return its result or error, or None if the process ends without one."""
        assert process.stdin is not None and process.stdout is not None
        self._log.truncate(0)
        self._log.seek(0)
        self._last_message = time.monotonic()
        try:
            with contextlib.suppress(OSError):
                process.stdin.write(protocol.encode({"id": 0, "method": task.method, "params": task.params}))
                process.stdin.flush()
            for line in process.stdout:
                try:
                    message = protocol.decode(line)
                except protocol.NotProtocol:
                    continue  # a library may print before serving starts
                self._last_message = time.monotonic()
                if "error" in message:
                    return protocol.to_exception(message["error"])
                if "result" in message:
                    return message["result"]
                self._outcomes.put((task, None, float(message.get("value", 0))))
            process.wait()
            return None
        finally:
            self._last_message = None

    def _describe_death(self, process: subprocess.Popen) -> WorkerFailed:
        """Return the error that tells how the process ended."""
        code = process.returncode
        ended = f"was killed by signal {-code}" if code < 0 else f"ended with status {code}"
        self._log.seek(0, os.SEEK_END)
        self._log.seek(max(self._log.tell() - 2000, 0))
        words = self._log.read().decode("utf-8", "replace").strip().splitlines()
        # If the process was killed from outside, its last output is irrelevant.
        last = f" Its last words: {words[-1][:200]}" if words and (self._hung or code not in (-9, -15)) else ""
        if self._hung:
            return WorkerFailed("The process was silent for too long and was ended.", f"Look at this clip alone.{last}")
        return WorkerFailed(f"The process {ended} at this clip.", f"Look at this clip alone, and at the free memory.{last}")
