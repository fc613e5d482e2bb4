"""``blender --command s2ag ...``: the verbs of the command line from inside Blender.

The verbs run in the engine's Python, which starts this Blender again for what needs it, so that their options, messages and
exit codes are those of the command line. Verbs that only the Python package has end in a sentence (:mod:`core.cli.parser`).
"""

import contextlib
import os
import signal
import subprocess
import sys

import bpy

from ...core.errors import Cancelled, S2agError
from ...core.start import module_command
from ..engine import client, known

FAILED, INTERRUPTED = 2, 130


def main(arguments: list[str]) -> int:
    """Run a verb and return its exit code: 0, 2 after an error (one sentence on stderr), 130 after Ctrl-C."""
    try:
        # Blender's own handler would set a flag that nobody here looks at.
        with _handling(signal.SIGINT, signal.default_int_handler):
            return _verb(arguments or ["--help"])
    except S2agError as error:
        _say(str(error) if not isinstance(error, Cancelled) else "cancelled.")
        return FAILED
    except KeyboardInterrupt:
        _say("interrupted.")
        return INTERRUPTED
    except SystemExit as leaving:  # --help and wrong options
        return int(leaving.code or 0)


@contextlib.contextmanager
def _handling(number: int, handler):
    """Handle a signal differently for a while."""
    former = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, signal.SIG_DFL if former is None else former)  # Blender's is not Python's to give back


def _verb(arguments: list[str]) -> int:
    """Hand a verb to the engine's Python. Ctrl-C reaches it by itself, being in the same terminal; a kill is passed on."""
    python = client.find_interpreter(known.interpreter(bpy.context))
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONSAFEPATH")}
    if bpy.app.binary_path:
        variables["S2AG_BLENDER"] = bpy.app.binary_path
    process = subprocess.Popen([*module_command(python, "core.cli.main"), *arguments], env=variables)
    with _handling(signal.SIGTERM, lambda *_: process.terminate()):
        while True:
            with contextlib.suppress(KeyboardInterrupt):
                return process.wait()


def _say(sentence: str) -> None:
    with contextlib.suppress(BrokenPipeError):
        print(f"s2ag: {' '.join(sentence.split())}", file=sys.stderr, flush=True)


_handle = None


def register() -> None:
    """Make ``blender --command s2ag`` known."""
    global _handle
    _handle = bpy.utils.register_cli_command("s2ag", main)


def unregister() -> None:
    """Undo :func:`register`."""
    global _handle
    bpy.utils.unregister_cli_command(_handle)
    _handle = None
