"""Checks whether a Python can run the engine: a child process of it must decode a clip and generate gestures for it.

A full engine is the package ``s2ag[full]`` in a Python of the user's; its version must be that of this code."""

import contextlib
import json
import os
import re
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path

from .. import child_process
from ..errors import Cancelled, EngineMissing, S2agError, WorkerFailed
from ..start import module_command, package_command
from ..version import VERSION

PAUSE = 0.05
"""Seconds between polls while waiting."""
_INSTALL = 'In a terminal, let that Python run: -m pip install "s2ag[full]"'
_UPGRADE = f'In a terminal, let that Python run: -m pip install --upgrade "s2ag[full]=={VERSION}"'
_NO_MODULE = re.compile(r"No module named '?s2ag\b(\.?)")
_IMPORT_LIMIT = 60
"""Seconds that a Python may take to import the package."""
_MAX_OUTPUT = 100_000
"""Bytes that are read from the end of the child's output."""


def find_python(path: str | os.PathLike) -> str:
    """Return the Python at ``path``: the program itself, or that of an environment's folder.

    In a folder with environments ``engine-N``, as older versions made them, it is that of the newest. Raises
    :class:`EngineMissing` for a folder without a Python."""
    path = Path(path)
    if not path.is_dir():
        return str(path)
    environments = [folder for folder in path.glob("engine-*") if folder.name[7:].isdecimal()]
    for folder in [path, *sorted(environments, key=lambda folder: int(folder.name[7:]), reverse=True)]:
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        if python.exists():
            return str(python)
    raise EngineMissing(f"There is no Python in {path}.", "Choose a Python, or the folder of its environment.")


def command(python: str | None) -> list[str]:
    """Return the command by which ``python`` generates gestures for a clip and prints what it has for the engine.

    It runs the package ``s2ag`` of that Python; None is the running Python with this code."""
    module = "core.worker.inventory"
    return [*(package_command(python, module) if python else module_command(module)), "--try"]


class Check:
    """Checks ``python`` in a child process; after :meth:`poll` returned True, there are facts in ``result`` or an ``error``.

    It must have the package ``s2ag[full]`` in the version of this code. None is the running Python with this code, which needs
    no package. Raises :class:`WorkerFailed` if it cannot be started."""

    stage, value = "Try the engine", 0.0

    def __init__(self, python: str | None) -> None:
        self.result: dict | None = None
        self.error: S2agError | None = None
        self.lines: list[str] = []
        """The last lines of the child's output, once it has ended."""
        self._full = python is not None
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 the child writes to it until it ends
        pipes = {"stdin": subprocess.DEVNULL, "stdout": self._output, "stderr": subprocess.STDOUT}
        try:
            self._process = subprocess.Popen(
                command(python), env=child_process.environment(), **pipes, **child_process.own_group_options()
            )
        except OSError as error:
            self._output.close()
            raise _not_run(python or "This Python", error) from error

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
            child_process.kill_tree(self._process)
            self._process.wait()
            self._output.close()
            self.error = Cancelled("Cancelled.")

    def _read(self) -> list[str]:
        """Return the last lines of the child's output."""
        with self._output as file:
            file.seek(max(file.seek(0, os.SEEK_END) - _MAX_OUTPUT, 0))
            return file.read().decode("utf-8", "replace").splitlines()


def read_facts(lines: list[str], full: bool = False) -> dict:
    """Return the facts that the inventory printed; with ``full`` they must include this version and PyTorch.

    Raises :class:`WorkerFailed` if there are none or they name a problem, and :class:`EngineMissing` if the package or PyTorch
    is missing or the package is of another version."""
    for line in reversed(lines):
        with contextlib.suppress(ValueError):
            facts = json.loads(line) if line.startswith("{") else None
            if not isinstance(facts, dict):
                continue
            if full:
                require_version(str(facts.get("s2ag", "")))
            if facts.get("problem"):
                raise WorkerFailed(f"The engine does not work: {facts['problem']}.", _INSTALL)
            if full and not facts.get("packages", {}).get("torch"):
                raise EngineMissing("This Python has no PyTorch.", _INSTALL)
            return facts
    raise start_error(lines) or _no_engine(lines)


def start_error(lines: Iterable[str]) -> S2agError | None:
    """Return why a Python did not start the package, from the ``lines`` it printed; None if they do not say so."""
    for line in lines:
        if line.startswith("Unknown option: -P"):
            return WorkerFailed("This Python is older than 3.11.", "Choose Python 3.11 or newer.")
        if missing := _NO_MODULE.search(line):
            if missing[1]:
                return EngineMissing("This Python has another version of the package s2ag.", _UPGRADE)
            return EngineMissing("This Python does not have the package s2ag.", _INSTALL)
    return None


def require_version(version: str) -> None:
    """Raise :class:`EngineMissing` unless ``version`` of the package is that of this code."""
    if version != VERSION:
        raise EngineMissing(f"This Python has version {version} of the package s2ag instead of {VERSION}.", _UPGRADE)


def require_package(python: str) -> None:
    """Raise :class:`S2agError` unless ``python`` has the package ``s2ag`` in the version of this code; waits for its reply."""
    probe = [python, "-P", "-c", "import s2ag; print(s2ag.__version__)"]
    try:
        done = subprocess.run(probe, env=child_process.environment(), capture_output=True, text=True, timeout=_IMPORT_LIMIT)
    except OSError as error:
        raise _not_run(python, error) from error
    except subprocess.TimeoutExpired as error:
        raise _no_engine([]) from error
    if done.returncode:
        lines = done.stderr.splitlines()
        raise start_error(lines) or _no_engine(lines)
    require_version(done.stdout.strip())


def _no_engine(lines: list[str]) -> WorkerFailed:
    last = lines[-1] if lines else "it said nothing"
    return WorkerFailed(f"This Python cannot run the engine: {last.rstrip('.')}.", _INSTALL)


def _not_run(python: str, error: OSError) -> WorkerFailed:
    return WorkerFailed(f"{python} cannot be run: {error.strerror}.", "Choose another Python.")
