"""Runs a module of s2ag_blender in a Blender process and reads its progress, result and errors."""

import contextlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

from .. import child_process
from ..errors import BlenderUnavailable
from ..worker import protocol

ENTRY = Path(__file__).parents[1] / "start.py"
PREFIX = "s2ag-"
"""Prefix of the commands' temporary folders."""
LAST_WORDS = 30
"""Lines of Blender's own output that are printed when it fails."""


def command(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of s2ag_blender in ``$S2AG_BLENDER``, the package bpy, or ``blender`` of the path.

    Raises :class:`BlenderUnavailable` if there is none of them."""
    named = os.environ.get("S2AG_BLENDER", "")
    if named and not shutil.which(named):
        raise BlenderUnavailable(f"S2AG_BLENDER names {named}, which cannot be run.", "Let it name Blender's executable.")
    if not named and importlib.util.find_spec("bpy"):
        return [sys.executable, "-P", str(ENTRY), "--", f"s2ag_blender.{module}", *arguments]
    program = shutil.which(named or "blender")
    if not program:
        raise BlenderUnavailable(
            "There is no Blender here.",
            'In Python 3.11 or 3.13: pip install "s2ag[blender]"; in any other let S2AG_BLENDER name its executable.',
        )
    options = ["--background", "--factory-startup", "--python-exit-code", "1", "--python", str(ENTRY)]
    return [program, *options, "--", f"s2ag_blender.{module}", *arguments]


def run(module: str, *arguments: str, progress: Callable[[str, float], None] = lambda *_: None, talk: str = "last") -> dict:
    """Run ``module`` to its end and return the result it reports.

    The first of ``arguments`` is the path of the job; its folder is deleted with this process if it is a temporary one.
    ``progress(stage, value)`` is called with its progress. ``talk`` says which of Blender's other output is printed: ``all``,
    the ``last`` lines if it crashes, or ``none``. Raises the error that the module reports, or :class:`BlenderUnavailable` if
    Blender crashes."""
    last_event: dict = {}
    output: deque[str] = deque(maxlen=LAST_WORDS)
    with tempfile.TemporaryFile() as log:
        with _process(command(module, *arguments), None if talk == "all" else log, _own_folder(*arguments[:1])) as process:
            assert process.stdout is not None
            for line in process.stdout:
                event = protocol.event(line)
                if event is None:
                    output.append(line.decode("utf-8", "replace").rstrip())
                    if talk == "all":
                        print(output[-1], file=sys.stderr)
                elif event["event"] == "progress":
                    progress(str(event.get("stage", "")), float(event.get("value", 0)))
                else:
                    last_event = event
        if last_event.get("event") == "error":
            raise protocol.to_exception(last_event)
        if last_event.get("event") == "result":
            return last_event
        log.seek(0)
        output.extend(log.read().decode("utf-8", "replace").splitlines())
    if talk == "last":
        print(*output, sep="\n", file=sys.stderr)
    code = process.returncode
    ended = f"was killed by signal {-code}" if code < 0 else f"ended with status {code}"
    remedy = "What it said last stands above; s2ag doctor checks the set-up."
    raise BlenderUnavailable(f"Blender {ended} before it was done.", remedy)


def _own_folder(job: str = "") -> str:
    """Return the folder of the file ``job`` if it is one of our temporary folders, else ""."""
    folder = Path(job).absolute().parent
    is_ours = folder.parent == Path(tempfile.gettempdir()).absolute() and folder.name.startswith(PREFIX)
    return str(folder) if job and is_ours else ""


@contextlib.contextmanager
def _process(arguments: list[str], log: IO[bytes] | None, folder: str) -> Iterator[subprocess.Popen]:
    """Run a child process within the block; it also ends with this process, when its standard input ends."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    environment[child_process.HELD_VARIABLE] = folder
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": log}
    try:
        process = subprocess.Popen(arguments, **pipes, env=environment)
    except OSError as error:
        raise BlenderUnavailable(f"Blender cannot be started: {error.strerror}.", f"Check that {arguments[0]} runs.") from error
    try:
        yield process
        process.wait()
    finally:
        if process.poll() is None:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(5)
            process.kill()
            process.wait()
        assert process.stdout is not None and process.stdin is not None
        process.stdout.close()
        process.stdin.close()
