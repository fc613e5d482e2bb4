"""The work on the engine's environment while it runs: polled, never waited for, ended at once when cancelled."""

import contextlib
import json
import os
import shutil
import threading
import time
from collections import deque

from ..errors import Cancelled
from ..files import new_log
from . import pip, planning, trial
from .environment import SetupFailed, python_in, requirements
from .planning import Plan

FULL = 1e7
"""Bytes below which a disk counts as full when something failed."""


class Setup(trial.Polled):
    """Makes the environment of a :class:`Plan`. ``stage`` with its ``names``, ``value`` (0..1 within it) and ``line`` are
    current after :meth:`poll`; when that returned True, ``result`` has the facts of a working engine or ``error`` says why not.

    Raises :class:`SetupFailed` at once where the folder cannot be written to.
    """

    def __init__(self, plan: Plan):
        self.plan = plan
        self.stage, self.names, self.value, self.line = "Make the environment", {}, 0.0, ""
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
            raise SetupFailed(message, "Choose another folder for it.") from error
        self._variables = planning.clean_environment(self._temporary, plan.wheels)
        self._steps = [plan.make, plan.fill, trial.command(python_in(plan.environment))]
        self._program: trial.Program | None = None
        try:
            self._begin()
        except (SetupFailed, OSError) as error:
            self._fail(error)
        except BaseException:
            self.cancel()
            raise

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

    def cancel(self) -> None:
        """Stop at once; what was made so far is deleted in the background."""
        if not self.done:
            self._fail(Cancelled("Cancelled."))

    def _begin(self) -> None:
        command = self._steps[0]
        self._temporary.mkdir(exist_ok=True)
        self._write(f"$ {' '.join(command)}")
        self._program = trial.Program(command, self._variables)
        self._program.start()

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
            self._finish(trial.read_facts(list(self._said)))
            return
        if self._program.code:
            # What makes the environment keeps the reason to itself.
            full = ["No space left on device"] if shutil.disk_usage(self.plan.environment).free < FULL else []
            raise SetupFailed(*pip.explain([*full, *self._said], self.plan.source))
        self._said.clear()
        self._steps.pop(0)
        self.stage, self.names = (self._listener.stage if len(self._steps) == 2 else trial.STAGE), {}
        self.value, self.line = 0.0, ""
        self._begin()

    def _finish(self, facts: dict) -> None:
        place = self.plan.environment
        planning.discard(self._temporary)
        facts["requirements"], facts["recognise"] = requirements(self.plan.recognise), self.plan.recognise
        facts["made"] = time.strftime("%Y-%m-%d %H:%M")
        facts["source"], facts["commands"] = self.plan.source, self.plan.text
        unfinished = place / "engine.json.part"
        unfinished.write_text(json.dumps(facts, indent=1), "utf-8")
        (place / "building").unlink(missing_ok=True)
        os.replace(unfinished, place / "engine.json")
        self._write("The engine works.")
        self._log.close()
        self.result = facts
        self.cleaner = planning.tidy(place.parent, keep=place)

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
        """Delete the half-made environment; what dying processes still write is deleted with later tries."""
        for _ in range(20):
            planning.discard(self.plan.environment)
            if not self.plan.environment.exists():
                return
            time.sleep(0.1)

    def _write(self, line: str) -> None:
        self._log.write(line + "\n")
        self._log.flush()
