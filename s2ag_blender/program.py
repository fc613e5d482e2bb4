"""A Blender that works for a starter: one JSON file says what to do, JSON lines on stdout tell how it goes.

``progress`` (stage, value 0..1), then one ``result`` or ``error`` (kind, message, remedy); exit status 0, or 2 after an error.
"""

import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ..core import mistake
from ..core.child import hold_on, leave
from ..core.errors import BlenderUnavailable, S2agError, UsageError, readable
from ..core.files import abandon


@dataclass
class Voice:
    """Tells the starter what happens, one JSON object a line."""

    write: object
    seconds: dict = field(default_factory=dict)

    def say(self, event: str, **content) -> None:
        self.write(json.dumps({"event": event, **content}) + "\n")

    def progress(self, stage: str, value: float) -> None:
        self.say("progress", stage=stage, value=round(float(value), 4))

    @contextlib.contextmanager
    def stage(self, name: str):
        """A named part of the work: progress 0 before it, 1 after it, its time in the result."""
        started = time.perf_counter()
        self.progress(name, 0)
        yield
        self.progress(name, 1)
        self.seconds[name] = round(self.seconds.get(name, 0) + time.perf_counter() - started, 3)


def run(arguments: list[str], work: Callable[[str, Voice], dict], what: str = "job") -> int:
    """Let ``work(path, voice)`` do what the file says that is the only argument, and tell its result or error."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _end)
    hold_on()
    with own_stdout() as write:
        voice = Voice(write)
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
            what = f"This is a mistake in s2ag ({type(error).__name__}: {error})."
            voice.say("error", kind="Internal", message=readable(what), remedy=mistake.keep(error))
            return 2
    return 0


def _end(number, _frame) -> None:
    """Leave at once and no half file behind; an exception would be swallowed by Blender's handlers."""
    abandon()
    os._exit(128 + number)


def require_bpy() -> None:
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        raise BlenderUnavailable(
            f"Blender's module bpy cannot be loaded: {error}", 'Install it: pip install "s2ag[blender]"'
        ) from error


@contextlib.contextmanager
def own_stdout():
    """Yield a function that writes to the real stdout; all else that is printed, Blender's own chatter too, goes to stderr."""
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
                    leave()

            yield write
    finally:
        sys.stdout.flush()
        os.dup2(real, 1)
        os.close(real)
