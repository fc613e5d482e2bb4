"""Runs a job inside Blender as a child process: one JSON file describes the job, JSON lines on stdout report on it.

Events: ``progress`` (stage, value 0..1), then one ``result`` or ``error`` (kind, message, remedy). The exit status is 0, or
2 after an error."""

import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

from ..core import crash_log
from ..core.child_process import exit_now, exit_with_parent
from ..core.errors import BlenderUnavailable, S2agError, UsageError, sanitize
from ..core.files import delete_unfinished


@dataclass
class EventWriter:
    """Writes events for the parent process, one JSON object per line; ``seconds`` are durations by stage."""

    write: Callable[[str], None]
    seconds: dict[str, float] = field(default_factory=dict)

    def say(self, event: str, **content: Any) -> None:
        self.write(json.dumps({"event": event, **content}) + "\n")

    def progress(self, stage: str, value: float) -> None:
        self.say("progress", stage=stage, value=round(float(value), 4))

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Report progress 0 before and 1 after the body of a ``with`` block, and add its duration to ``seconds``."""
        started = time.perf_counter()
        self.progress(name, 0)
        yield
        self.progress(name, 1)
        self.seconds[name] = round(self.seconds.get(name, 0) + time.perf_counter() - started, 3)


def run(arguments: list[str], work: Callable[[str, EventWriter], dict], what: str = "job") -> int:
    """Call ``work(path, voice)`` with the only argument as the path of a job file; write its result or error as an event.

    ``what`` names the kind of job in error sentences. Returns the exit status."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _end)
    exit_with_parent()
    with redirect_stdout() as write:
        voice = EventWriter(write)
        try:
            if len(arguments) != 1:
                raise UsageError(f"A {what} needs one argument.", f"Name the {what} file.")
            require_bpy()
            voice.say("result", **work(arguments[0], voice))
        except S2agError as error:
            voice.say("error", kind=error.kind, message=error.message, remedy=error.remedy)
            return 2
        except Exception as error:
            if os.environ.get("S2AG_DEBUG"):
                raise
            message = f"This is a mistake in s2ag ({type(error).__name__}: {error})."
            voice.say("error", kind="Internal", message=sanitize(message), remedy=crash_log.write_log(error))
            return 2
    return 0


def _end(number: int, _frame: FrameType | None) -> None:
    """Remove unfinished files and exit at once; Blender's handlers would swallow an exception."""
    delete_unfinished()
    os._exit(128 + number)


def require_bpy() -> None:
    """Raise :class:`BlenderUnavailable` if bpy cannot be imported."""
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        raise BlenderUnavailable(
            f"Blender's module bpy cannot be loaded: {error}", 'Install it: pip install "s2ag[blender]"'
        ) from error


@contextlib.contextmanager
def redirect_stdout() -> Iterator[Callable[[str], None]]:
    """Yield a function that writes to the real stdout; everything else that is printed, also by Blender, goes to stderr."""
    sys.stdout.flush()
    real = os.dup(1)
    os.dup2(2, 1)
    try:
        with os.fdopen(os.dup(real), "w", encoding="utf-8") as stream:

            def write(text: str) -> None:
                try:
                    stream.write(text)
                    stream.flush()
                except BrokenPipeError:  # it may be noticed here before standard input ends
                    exit_now()

            yield write
    finally:
        sys.stdout.flush()
        os.dup2(real, 1)
        os.close(real)
