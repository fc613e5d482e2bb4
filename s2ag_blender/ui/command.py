"""``blender --command s2ag ...``: runs the verbs of the command line from Blender.

The verbs run in the engine's Python, with the options, messages and exit codes of the command line; it starts this Blender
again for verbs that need it. A Python that was chosen runs its own package; in Blender's Python, verbs that only the package
has end with an error (:mod:`core.cli.parser`)."""

import contextlib
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import bpy

from ...core import child_process
from ...core.errors import Cancelled, S2agError
from ...core.worker import interpreter
from ..datablocks import current_context
from ..engine import client, engine_state

FAILED, INTERRUPTED = 2, 130


def main(arguments: list[str]) -> int:
    """Run a verb and return its exit code: 0, 2 after an error (one sentence on stderr), 130 after Ctrl-C."""
    try:
        # Blender's own handler only sets a flag, which is not read here.
        with _signal_handler(signal.SIGINT, signal.default_int_handler):
            return _verb(arguments or ["--help"])
    except S2agError as error:
        _say(str(error) if not isinstance(error, Cancelled) else "cancelled.")
        return FAILED
    except KeyboardInterrupt:
        _say("interrupted.")
        return INTERRUPTED
    except SystemExit as exit_request:  # --help and wrong options
        return int(exit_request.code or 0)


@contextlib.contextmanager
def _signal_handler(number: int, handler: Callable[..., Any]) -> Iterator[None]:
    """Install a signal handler within the block."""
    former = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, signal.SIG_DFL if former is None else former)  # Blender's is not Python's to give back


def _verb(arguments: list[str]) -> int:
    """Run a verb in the engine's Python and return its exit code.

    The child shares the terminal, so Ctrl-C reaches it, too; SIGTERM is passed on. Raises :class:`S2agError` if a Python that
    was chosen does not have the package in this version."""
    python = engine_state.interpreter(current_context())
    if client.is_chosen(python):
        interpreter.require_package(client.find_interpreter(python))
    variables = child_process.environment()
    if bpy.app.binary_path:
        variables["S2AG_BLENDER"] = bpy.app.binary_path
    process = subprocess.Popen([*client.engine_command("core.cli.main", python), *arguments], env=variables)
    with _signal_handler(signal.SIGTERM, lambda *_: process.terminate()):
        while True:
            with contextlib.suppress(KeyboardInterrupt):
                return process.wait()


def _say(sentence: str) -> None:
    """Print a sentence to stderr as one line."""
    with contextlib.suppress(BrokenPipeError):
        print(f"s2ag: {' '.join(sentence.split())}", file=sys.stderr, flush=True)


_handle = None


def register() -> None:
    """Register the command ``blender --command s2ag``."""
    global _handle
    _handle = bpy.utils.register_cli_command("s2ag", main)


def unregister() -> None:
    """Undo :func:`register`."""
    global _handle
    bpy.utils.unregister_cli_command(_handle)
    _handle = None
