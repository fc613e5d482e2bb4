"""A crew of child processes that share out tasks; a task that kills or hangs its process fails alone."""

import contextlib
import os
import queue
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from .. import child
from ..engine import protocol
from ..errors import S2agError, WorkerFailed
from ..threads import ONE_EACH

TRIES = 2
"""A task whose process died may have been the victim of another program's hunger for memory, so it is tried again."""
PATIENCE = 1800.0
"""Seconds without a word from a busy process after which it counts as hung."""

LAST_WAIT = 10.0
"""Seconds that the end of a crew waits for a thread or a process that was killed."""


@dataclass(frozen=True)
class Task:
    """``method`` of the children and its ``params`` (JSON); ``label`` is the caller's own."""

    method: str
    params: dict
    label: object = field(default=None, compare=False)


class Crew:
    """``size`` processes of ``command`` (:mod:`serving` inside), each started with its first task and then kept."""

    def __init__(self, command: Sequence[str], size: int, patience: float = PATIENCE):
        self._command, self._size, self._patience = list(command), max(size, 1), patience

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, dict | S2agError | None, float]]:
        """Do all ``tasks`` in their order; yields ``(task, result or error, 1)`` as they end, and on the way
        ``(task, None, share done)``.

        No process outlives the iterator, however it ends.
        """
        todo: queue.SimpleQueue = queue.SimpleQueue()
        for task in tasks:
            todo.put(task)
        told: queue.SimpleQueue = queue.SimpleQueue()
        members = [_Member(self._command, todo, told) for _ in range(min(self._size, len(tasks)))]
        try:
            left = len(tasks)
            while left:
                try:
                    task, outcome, share = told.get(timeout=min(1.0, self._patience / 4))
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
    """A thread that feeds one process, and the process."""

    def __init__(self, command: list[str], todo: queue.SimpleQueue, told: queue.SimpleQueue):
        self._command, self._todo, self._told = command, todo, told
        self._process: subprocess.Popen | None = None
        self._log = tempfile.TemporaryFile("w+b", buffering=0)  # noqa: SIM115 - closed in end()
        self._ending = self._hung = False
        self._starting = threading.Lock()
        self._heard: float | None = None
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def watch(self, patience: float) -> None:
        """Kill a busy process that has been silent for too long."""
        heard = self._heard
        if heard is not None and time.monotonic() - heard > patience:
            self._hung = True
            child.end(self._process)

    def end(self) -> None:
        """Kill the process: nothing of what it is doing is needed, and all it has done has landed."""
        with self._starting:  # after this no process is started any more
            self._ending = True
        if self._process is not None:
            child.end(self._process)
        self._thread.join(LAST_WAIT)
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):  # one that the system cannot kill is the system's
                self._process.wait(LAST_WAIT)
        self._log.close()

    def _work(self) -> None:
        with contextlib.suppress(queue.Empty):
            while not self._ending:
                task = self._todo.get_nowait()
                try:
                    outcome = self._do(task)
                except Exception as error:  # into the main thread, where it is seen
                    outcome = error
                if not self._ending:
                    self._told.put((task, outcome, 1.0))

    def _do(self, task: Task) -> dict | S2agError:
        error: S2agError | None = None
        for _ in range(TRIES):
            if self._ending:
                break
            if (self._process is None or self._process.poll() is not None) and not self._start():
                break
            answer = self._ask(task)
            if answer is not None:
                return answer
            error = self._epitaph()
            if self._hung:
                break
        return error or WorkerFailed("The batch was ended.")

    def _start(self) -> bool:
        """Start the process; False where the crew is being ended, which waits for the last process that it knows of."""
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"} | ONE_EACH
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self._log}
        with self._starting:
            if self._ending:
                return False
            self._hung = False
            try:
                # Ctrl-C is for the parent, which ends them; one that dies of it first would look like a failed clip.
                self._process = subprocess.Popen(self._command, **pipes, env=environment, **child.apart())
            except OSError as error:
                what = f"{self._command[0]} cannot be started: {error.strerror}."
                raise WorkerFailed(what, "Check that it runs.") from error
        return True

    def _ask(self, task: Task) -> dict | S2agError | None:
        """The answer to a task, or None when the process ended without one."""
        self._log.truncate(0)
        self._log.seek(0)
        self._heard = time.monotonic()
        try:
            with contextlib.suppress(OSError):
                self._process.stdin.write(protocol.encode({"id": 0, "method": task.method, "params": task.params}))
                self._process.stdin.flush()
            for line in self._process.stdout:
                try:
                    message = protocol.decode(line)
                except protocol.NotProtocol:
                    continue  # what a library prints before serving begins
                self._heard = time.monotonic()
                if "error" in message:
                    return protocol.revive(message["error"])
                if "result" in message:
                    return message["result"]
                self._told.put((task, None, float(message.get("value", 0))))
            self._process.wait()
            return None
        finally:
            self._heard = None

    def _epitaph(self) -> WorkerFailed:
        code = self._process.returncode
        ended = f"was killed by signal {-code}" if code < 0 else f"ended with status {code}"
        self._log.seek(0, os.SEEK_END)
        self._log.seek(max(self._log.tell() - 2000, 0))
        words = self._log.read().decode("utf-8", "replace").strip().splitlines()
        # Of one that somebody else killed they would be chatter.
        last = f" Its last words: {words[-1][:200]}" if words and (self._hung or code not in (-9, -15)) else ""
        if self._hung:
            return WorkerFailed("The process was silent for too long and was ended.", f"Look at this clip alone.{last}")
        return WorkerFailed(f"The process {ended} at this clip.", f"Look at this clip alone, and at the free memory.{last}")
