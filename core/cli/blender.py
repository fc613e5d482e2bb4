"""Runs a job of s2ag_blender in a Blender process of its own and listens to it."""

import contextlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Callable
from pathlib import Path

from .. import child
from ..engine import protocol
from ..errors import BlenderUnavailable

ENTRY = Path(__file__).parents[1] / "start.py"
PREFIX = "s2ag-"
"""How the commands' temporary folders are called."""
LAST_WORDS = 30
"""Lines of Blender's own output that are shown when it fails."""


def command(module: str, *arguments: str) -> list[str]:
    """The command that runs ``module`` of s2ag_blender: by ``$S2AG_BLENDER``, the package bpy, or ``blender`` on the path.

    Raises :class:`BlenderUnavailable` when there is none of them.
    """
    named = os.environ.get("S2AG_BLENDER", "")
    if named and not shutil.which(named):
        raise BlenderUnavailable(f"S2AG_BLENDER names {named}, which cannot be run.", "Let it name Blender's executable.")
    if not named and importlib.util.find_spec("bpy"):
        return [sys.executable, "-P", str(ENTRY), "--", f"s2ag_blender.{module}", *arguments]
    program = shutil.which(named or "blender")
    if not program:
        raise BlenderUnavailable(
            "There is no Blender here.",
            'Install it with: pip install "s2ag[blender]", or let S2AG_BLENDER name its executable.',
        )
    options = ["--background", "--factory-startup", "--python-exit-code", "1", "--python", str(ENTRY)]
    return [program, *options, "--", f"s2ag_blender.{module}", *arguments]


def run(module: str, *arguments: str, progress: Callable[[str, float], None] = lambda *_: None, talk: str = "last") -> dict:
    """Run ``module`` to its end and return the result it reports.

    The first of ``arguments`` is the file that says what to do; its folder goes with this process if it is a temporary one.
    ``progress(stage, value)`` hears of its progress. Of Blender's own chatter, ``talk`` shows ``all``, the ``last`` lines
    if it dies, or ``none``. Raises the error that the module reports, or :class:`BlenderUnavailable` if Blender dies.
    """
    heard: dict = {}
    chatter: deque[str] = deque(maxlen=LAST_WORDS)
    with tempfile.TemporaryFile() as log:
        with _process(command(module, *arguments), None if talk == "all" else log, _own_folder(*arguments[:1])) as process:
            for line in process.stdout:
                event = protocol.event(line)
                if event is None:
                    chatter.append(line.decode("utf-8", "replace").rstrip())
                    if talk == "all":
                        print(chatter[-1], file=sys.stderr)
                elif event["event"] == "progress":
                    progress(str(event.get("stage", "")), float(event.get("value", 0)))
                else:
                    heard = event
        if heard.get("event") == "error":
            raise protocol.revive(heard)
        if heard.get("event") == "result":
            return heard
        log.seek(0)
        chatter.extend(log.read().decode("utf-8", "replace").splitlines())
    if talk == "last":
        print(*chatter, sep="\n", file=sys.stderr)
    code = process.returncode
    ended = f"was killed by signal {-code}" if code < 0 else f"ended with status {code}"
    remedy = "What it said last stands above; s2ag doctor checks the set-up."
    raise BlenderUnavailable(f"Blender {ended} before it was done.", remedy)


def _own_folder(task: str = "") -> str:
    """The folder of ``task`` if it was made for it among the temporary files, else "": others are their owners'."""
    folder = Path(task).absolute().parent
    made = folder.parent == Path(tempfile.gettempdir()).absolute() and folder.name.startswith(PREFIX)
    return str(folder) if task and made else ""


@contextlib.contextmanager
def _process(arguments: list[str], log, folder: str):
    """A child process that never outlives the block, nor this process: the end of its standard input tells it."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    environment[child.HELD] = folder
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": log}
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
        process.stdout.close()
        process.stdin.close()
