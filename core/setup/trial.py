"""An engine is tried: its Python decodes and gestures a clip in a process of its own, which nobody waits for."""

import contextlib
import json
import os
import queue
import subprocess
import threading
import time
from collections import deque

from .. import child
from ..errors import Cancelled, S2agError
from ..start import module_command
from .environment import SetupFailed

STAGE = "Try the engine"
PAUSE = 0.05
"""Seconds between looks while waiting."""

_AGAIN = "Run the set-up command again, or choose another engine."


def command(python: str | os.PathLike) -> list[str]:
    """The command that prints what ``python`` has for the engine, once that has gestured a clip."""
    return [*module_command(os.fspath(python), "core.engine.inventory"), "--try"]


class Program:
    """A child process whose output is read in a thread, line by line; dies with all its own children.

    Making one does nothing yet. A signal, which comes to the main thread, can interrupt :meth:`start` anywhere: the process
    is started in the other thread, and whoever holds the program can :meth:`kill` it, however far that is.
    """

    def __init__(self, command: list[str], variables: dict | None = None):
        self._command, self._variables = command, variables
        self._popen: subprocess.Popen | None = None
        self._failed: OSError | None = None
        self._starting, self._begun, self._killed = threading.Lock(), threading.Event(), False
        self.lines: queue.SimpleQueue = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Begin; raises :class:`SetupFailed` where it cannot be run."""
        self._reader.start()
        self._begun.wait()
        if self._failed:
            reason = f"{self._command[0]} cannot be run: {self._failed.strerror}."
            raise SetupFailed(reason, "Choose another Python.") from self._failed

    def done(self) -> bool:
        """Whether it ended and all that it said is in ``lines``."""
        # Asked in this order, a program is not waited for while its own children live, and so they can still be ended with it.
        return not self._reader.is_alive() and self._popen.poll() is not None

    @property
    def code(self) -> int | None:
        """Its exit status."""
        return self._popen.poll()

    def kill(self) -> None:
        """End it and what it started, now; one that has not begun never will."""
        with self._starting:
            self._killed = True
        if self._popen is not None:
            child.end(self._popen)

    def _run(self) -> None:
        try:
            with self._starting:
                if self._killed:
                    return
                self._popen = subprocess.Popen(
                    self._command,
                    env=self._variables,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    **child.apart(),
                )
        except OSError as error:
            self._failed = error
            return
        finally:
            self._begun.set()
        with self._popen.stdout as pipe:
            for line in pipe:
                self.lines.put(line.decode("utf-8", "replace").rstrip())


class Polled:
    """Work that :meth:`poll` looks after: its ``stage`` with its ``names`` and ``value``, then its ``result`` or ``error``."""

    result: dict | None = None
    error: S2agError | None = None

    @property
    def done(self) -> bool:
        """Whether it ended, one way or the other."""
        return self.result is not None or self.error is not None

    def wait(self, progress=None) -> dict:
        """Wait for the end and return the facts, or raise the error; Ctrl-C cancels and is passed on."""
        try:
            while not self.poll():
                if progress:
                    progress(self.stage.format(**self.names), self.value)
                time.sleep(PAUSE)
        except BaseException:
            self.cancel()
            raise
        if self.error:
            raise self.error
        return self.result


class Check(Polled):
    """Lets an interpreter gesture a clip; ``result`` are facts about its engine once :meth:`poll` returned True."""

    def __init__(self, python: str | os.PathLike):
        self.stage, self.names, self.value, self.line = STAGE, {}, 0.0, ""
        self.said: deque[str] = deque(maxlen=40)
        """What it printed last."""
        self._program = Program(command(python))
        try:
            self._program.start()
        except BaseException:
            self._program.kill()
            raise

    def poll(self) -> bool:
        """Look how it goes, without waiting."""
        if not self.done and self._program.done():
            while not self._program.lines.empty():
                self.said.append(self._program.lines.get())
            try:
                self.result = read_facts(list(self.said))
            except SetupFailed as error:
                self.error = error
        return self.done

    def cancel(self) -> None:
        """Stop at once."""
        self._program.kill()
        self.error = self.error or Cancelled("Cancelled.")


def read_facts(lines: list[str]) -> dict:
    """The facts that the inventory printed; raises :class:`SetupFailed` where it did not or there is a problem."""
    for line in reversed(lines):
        if line.startswith("{"):
            with contextlib.suppress(ValueError):
                facts = json.loads(line)
                if facts.get("problem"):
                    raise SetupFailed(f"The engine does not work: {facts['problem']}.", _AGAIN)
                return facts
    said = lines[-1] if lines else "it said nothing"
    raise SetupFailed(f"This Python cannot run the engine: {said.rstrip('.')}.", _AGAIN)
