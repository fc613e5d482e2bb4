"""Checks whether another Python can run the engine: a child process of it must decode a clip and generate gestures for it."""

import contextlib
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from .. import child
from ..errors import Cancelled, EngineMissing, S2agError, WorkerFailed
from ..start import module_command

PAUSE = 0.05
"""Seconds between polls while waiting."""
_INSTALL = 'In a terminal, let that Python run: -m pip install "s2ag[full]"'
_MAX_OUTPUT = 100_000
"""Bytes that are read from the end of the child's output."""


def python_in(path: str | os.PathLike) -> str:
    """Return the Python at ``path``: the program itself, or that of an environment's folder.

    In a folder with environments ``engine-N``, as older versions made them, it is that of the newest. Raises
    :class:`EngineMissing` for a folder without a Python.
    """
    path = Path(path)
    if not path.is_dir():
        return str(path)
    environments = [folder for folder in path.glob("engine-*") if folder.name[7:].isdecimal()]
    for folder in [path, *sorted(environments, key=lambda folder: int(folder.name[7:]), reverse=True)]:
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        if python.exists():
            return str(python)
    raise EngineMissing(f"There is no Python in {path}.", "Choose a Python, or the folder of its environment.")


def command(python: str) -> list[str]:
    """Return the command by which ``python`` generates gestures for a clip and prints what it has for the engine."""
    return [*module_command(python, "core.engine.inventory"), "--try"]


class Check:
    """Checks ``python`` in a child process; after :meth:`poll` returned True, there are facts in ``result`` or an ``error``.

    With ``full`` it must have PyTorch, too. Raises :class:`WorkerFailed` if it cannot be started.
    """

    stage, value = "Try the engine", 0.0

    def __init__(self, python: str, full: bool = False) -> None:
        self.result: dict | None = None
        self.error: S2agError | None = None
        self.lines: list[str] = []
        """The last lines of the child's output, once it has ended."""
        self._full = full
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 the child writes to it until it ends
        variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONSAFEPATH")}
        pipes = {"stdin": subprocess.DEVNULL, "stdout": self._output, "stderr": subprocess.STDOUT}
        try:
            self._process = subprocess.Popen(command(python), env=variables, **pipes, **child.apart())
        except OSError as error:
            self._output.close()
            raise WorkerFailed(f"{python} cannot be run: {error.strerror}.", "Choose another Python.") from error

    @property
    def done(self) -> bool:
        """Whether it has ended, with a result or an error."""
        return self.result is not None or self.error is not None

    def poll(self) -> bool:
        """Return whether it has ended, without waiting."""
        if not self.done and self._process.poll() is not None:
            self.lines = self._read()
            try:
                self.result = read_facts(self.lines, self._full)
            except S2agError as error:
                self.error = error
        return self.done

    def wait(self, progress: Callable[[str, float], None] | None = None) -> dict:
        """Wait for the end and return the facts, or raise the error; Ctrl-C cancels and is passed on."""
        try:
            while not self.poll():
                if progress:
                    progress(self.stage, self.value)
                time.sleep(PAUSE)
        except BaseException:
            self.cancel()
            raise
        if self.error is not None:
            raise self.error
        assert self.result is not None
        return self.result

    def cancel(self) -> None:
        """Kill the child and its own children."""
        if not self.done:
            child.end(self._process)
            self._process.wait()
            self._output.close()
            self.error = Cancelled("Cancelled.")

    def _read(self) -> list[str]:
        """Return the last lines of the child's output."""
        with self._output as file:
            file.seek(max(file.seek(0, os.SEEK_END) - _MAX_OUTPUT, 0))
            return file.read().decode("utf-8", "replace").splitlines()


def read_facts(lines: list[str], full: bool = False) -> dict:
    """Return the facts that the inventory printed; with ``full`` they must include PyTorch.

    Raises :class:`WorkerFailed` where there are none or they name a problem, and :class:`EngineMissing` without PyTorch.
    """
    for line in reversed(lines):
        with contextlib.suppress(ValueError):
            facts = json.loads(line) if line.startswith("{") else None
            if not isinstance(facts, dict):
                continue
            if facts.get("problem"):
                raise WorkerFailed(f"The engine does not work: {facts['problem']}.", _INSTALL)
            if full and not facts.get("packages", {}).get("torch"):
                raise EngineMissing("This Python has no PyTorch.", _INSTALL)
            return facts
    last = lines[-1] if lines else "it said nothing"
    if any(line.startswith("Unknown option: -P") for line in lines):
        raise WorkerFailed("This Python is older than 3.11.", "Choose Python 3.11 or newer.")
    raise WorkerFailed(f"This Python cannot run the engine: {last.rstrip('.')}.", _INSTALL)
