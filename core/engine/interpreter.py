"""Checks another Python that may run the engine: a child process of it has to decode and gesture a clip."""

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
"""Seconds between looks while waiting."""
_INSTALL = 'In a terminal, let that Python run: -m pip install "s2ag[full]"'
_LARGEST_OUTPUT = 100_000
"""Bytes that are read from the end of what the child printed."""


def python_in(path: str | os.PathLike) -> str:
    """Return the Python that ``path`` means: a program itself, or that of an environment's folder.

    A folder with environments ``engine-N`` means the newest of them; earlier set-ups made such folders. Raises
    :class:`EngineMissing` for a folder without a Python.
    """
    path = Path(path)
    if not path.is_dir():
        return str(path)
    made = [folder for folder in path.glob("engine-*") if folder.name[7:].isdecimal()]
    for folder in [path, *sorted(made, key=lambda folder: int(folder.name[7:]), reverse=True)]:
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        if python.exists():
            return str(python)
    raise EngineMissing(f"There is no Python in {path}.", "Choose a Python, or the folder of its environment.")


def command(python: str) -> list[str]:
    """Return the command that prints what ``python`` has for the engine, once that has gestured a clip."""
    return [*module_command(python, "core.engine.inventory"), "--try"]


class Check:
    """Lets ``python`` gesture a clip; after :meth:`poll` returned True, ``result`` has its facts or ``error`` says why not.

    With ``full`` it must have PyTorch, too. Raises :class:`WorkerFailed` where it cannot be started.
    """

    stage, value = "Try the engine", 0.0

    def __init__(self, python: str, full: bool = False):
        self.result: dict | None = None
        self.error: S2agError | None = None
        self.lines: list[str] = []
        """What the child printed last, once it has ended."""
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
        """Whether it ended, one way or the other."""
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
        """Stop the child at once, with all that it has started."""
        if not self.done:
            child.end(self._process)
            self._process.wait()
            self._output.close()
            self.error = Cancelled("Cancelled.")

    def _read(self) -> list[str]:
        with self._output as file:
            file.seek(max(file.seek(0, os.SEEK_END) - _LARGEST_OUTPUT, 0))
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
