"""The work on the engine's environment while it runs: polled, never waited for, ended at once when cancelled."""

import contextlib
import itertools
import json
import os
import queue
import shutil
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

from ...core import child
from ...core.errors import Cancelled, S2agError
from . import pip, setup
from .setup import Plan, SetupFailed

PAUSE = 0.05
"""Seconds between looks while waiting."""
LOGS = 10
"""Logs of a kind that are kept."""
FULL = 1e7
"""Bytes below which a disk counts as full when something failed."""

_CHECK = "Try the engine"


class Program:
    """A child process whose output is read in a thread, line by line; dies with all its own children."""

    def __init__(self, command: list[str], variables: dict | None = None):
        try:
            self._popen = subprocess.Popen(
                command,
                env=variables,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                **child.apart(),
            )
        except OSError as error:
            raise SetupFailed(f"{command[0]} cannot be run: {error.strerror}.", "Choose another Python.") from error
        self.lines: queue.SimpleQueue = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def done(self) -> bool:
        """Whether it ended and all that it said is in ``lines``."""
        # Asked in this order, a program is not waited for while its own children live, and so they can still be ended with it.
        return not self._reader.is_alive() and self._popen.poll() is not None

    @property
    def code(self) -> int | None:
        """Its exit status."""
        return self._popen.poll()

    def kill(self) -> None:
        """End it and what it started, now."""
        child.end(self._popen)

    def _read(self) -> None:
        with self._popen.stdout as pipe:
            for line in pipe:
                self.lines.put(line.decode("utf-8", "replace").rstrip())


class Check:
    """Lets an interpreter gesture a clip; ``result`` are facts about its engine once :meth:`poll` returned True."""

    def __init__(self, python: str | os.PathLike):
        self.stage, self.names, self.value, self.line = _CHECK, {}, 0.0, ""
        self.result: dict | None = None
        self.error: S2agError | None = None
        self._said: deque[str] = deque(maxlen=40)
        self._program = Program(setup.trial_command(python))

    @property
    def done(self) -> bool:
        """Whether it ended."""
        return self.result is not None or self.error is not None

    def poll(self) -> bool:
        """Look how it goes, without waiting."""
        if not self.done and self._program.done():
            while not self._program.lines.empty():
                self._said.append(self._program.lines.get())
            try:
                self.result = read_facts(list(self._said))
            except SetupFailed as error:
                self.error = error
        return self.done

    def cancel(self) -> None:
        """Stop at once."""
        self._program.kill()
        self.error = self.error or Cancelled("Cancelled.")


class Setup:
    """Makes the environment of a :class:`Plan`. ``stage`` with its ``names``, ``value`` (0..1 within it) and ``line`` are
    current after :meth:`poll`; when that returned True, ``result`` has the facts of a working engine or ``error`` says why not.

    Raises :class:`SetupFailed` at once where the folder cannot be written to.
    """

    def __init__(self, plan: Plan):
        self.plan = plan
        self.stage, self.names, self.value, self.line = "Make the environment", {}, 0.0, ""
        self.result: dict | None = None
        self.error: S2agError | None = None
        self._listener = pip.Listener()
        self._said: deque[str] = deque(maxlen=200)
        self._looked = 0.0
        self._temporary = plan.environment / "temporary"
        self.cleaner: threading.Thread | None = None
        """Deletes what is of no more use, once the set-up ended."""
        try:
            (plan.environment.parent / "logs").mkdir(parents=True, exist_ok=True)
            self.log = new_log(plan.environment.parent / "logs", "setup")
            self._log = self.log.open("w", encoding="utf-8")
            plan.environment.mkdir()
        except OSError as error:
            message = f"{plan.environment} cannot be made: {error.strerror or error}."
            raise SetupFailed(message, "Choose a user folder for Blender that can be written to.") from error
        self._variables = setup.clean_environment(self._temporary, plan.wheels)
        self._steps = [plan.make, plan.fill, setup.trial_command(setup.python_in(plan.environment))]
        self._program: Program | None = None
        try:
            self._begin()
        except (SetupFailed, OSError) as error:
            self._fail(error)

    @property
    def done(self) -> bool:
        """Whether it ended, one way or the other."""
        return self.result is not None or self.error is not None

    def poll(self) -> bool:
        """Take in what was said and go on to the next step, without waiting."""
        try:
            if not self.done:
                finished = self._program.done()
                self._hear()
                if finished:
                    self._end_step()
        except (SetupFailed, OSError) as error:
            self._fail(error)
        return self.done

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

    def cancel(self) -> None:
        """Stop at once; what was made so far is deleted in the background."""
        if not self.done:
            self._fail(Cancelled("Cancelled."))

    def _begin(self) -> None:
        command = self._steps[0]
        self._temporary.mkdir(exist_ok=True)
        self._write(f"$ {' '.join(command)}")
        self._program = Program(command, self._variables)

    def _hear(self) -> None:
        filling = len(self._steps) == 2
        while not self._program.lines.empty():
            line = self._program.lines.get()
            self._write(line)
            self._said.append(line)
            if filling and line.strip():
                self._listener.hear(line)
                self.line = line.strip()
        if time.monotonic() - self._looked < 0.4:
            return
        self._looked = time.monotonic()
        (self.plan.environment / "building").touch()
        if filling:
            packages = next(self.plan.environment.glob("[Ll]ib/**/site-packages"), self.plan.environment)
            value = self._listener.value(self._temporary, packages)
            stage = self._listener.stage, self._listener.names
            # pip moves folders about while it installs, but for people there is only forward.
            self.value = max(value, self.value) if stage == (self.stage, self.names) else value
            self.stage, self.names = stage

    def _end_step(self) -> None:
        if len(self._steps) == 1:
            self._finish(read_facts(list(self._said)))
            return
        if self._program.code:
            # What makes the environment keeps the reason to itself.
            full = ["No space left on device"] if shutil.disk_usage(self.plan.environment).free < FULL else []
            raise SetupFailed(*pip.explain([*full, *self._said], self.plan.source))
        self._said.clear()
        self._steps.pop(0)
        self.stage, self.names = (self._listener.stage if len(self._steps) == 2 else _CHECK), {}
        self.value, self.line = 0.0, ""
        self._begin()

    def _finish(self, facts: dict) -> None:
        place = self.plan.environment
        setup.discard(self._temporary)
        facts["requirements"], facts["recognise"] = setup.requirements(self.plan.recognise), self.plan.recognise
        facts["made"] = time.strftime("%Y-%m-%d %H:%M")
        facts["source"], facts["commands"] = self.plan.source, self.plan.text
        unfinished = place / "engine.json.part"
        unfinished.write_text(json.dumps(facts, indent=1), "utf-8")
        (place / "building").unlink(missing_ok=True)
        os.replace(unfinished, place / "engine.json")
        self._write("The engine works.")
        self._log.close()
        self.result = facts
        self.cleaner = setup.tidy(place.parent, keep=place)

    def _fail(self, error: Exception) -> None:
        if isinstance(error, OSError):
            error = SetupFailed(*pip.explain([str(error)], self.plan.source))
        if self._program:
            self._program.kill()
        with contextlib.suppress(OSError, ValueError):  # a full disk has no room for the last line either
            self._write(str(error))
            self._log.close()
        if isinstance(error, SetupFailed):
            error.log = self.log
        self.error = error
        self.cleaner = threading.Thread(target=self._clean, name="s2ag clean")
        self.cleaner.start()

    def _clean(self) -> None:
        """Delete the half-made environment; what its dying processes still write is deleted with the second try."""
        for _ in range(20):
            setup.discard(self.plan.environment)
            if not self.plan.environment.exists():
                return
            time.sleep(0.1)

    def _write(self, line: str) -> None:
        self._log.write(line + "\n")
        self._log.flush()


def read_facts(lines: list[str]) -> dict:
    """The facts that the inventory printed; raises :class:`SetupFailed` where it did not or there is a problem."""
    for line in reversed(lines):
        if line.startswith("{"):
            with contextlib.suppress(ValueError):
                facts = json.loads(line)
                if facts.get("problem"):
                    raise SetupFailed(f"The engine does not work: {facts['problem']}.", "Repair it; the log has the details.")
                return facts
    said = lines[-1] if lines else "it said nothing"
    raise SetupFailed(f"This Python cannot run the engine: {said.rstrip('.')}.", "Set the engine up, or choose another Python.")


def new_log(folder: Path, kind: str) -> Path:
    """A name for a new log in ``folder``, whose oldest logs of that kind are deleted."""
    for old in sorted(folder.glob(f"{kind}-*.log"))[: 1 - LOGS]:
        old.unlink(missing_ok=True)
    stem = f"{kind}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = (folder / f"{stem}{f'-{number}' if number else ''}.log" for number in itertools.count())
    return next(name for name in names if not name.exists())
