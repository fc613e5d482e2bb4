"""``blender --command s2ag ...``: the verbs of the command line from inside Blender, and the engine's set-up without a window.

The verbs run in the engine's own Python, which starts this Blender again for what needs it, so that their options, messages
and exit codes are those of the command line.
"""

import argparse
import contextlib
import os
import signal
import subprocess
import sys

import bpy

from ...core.errors import Cancelled, S2agError
from ..engine import client, known, setup
from . import engine_ops

FAILED, INTERRUPTED = 2, 130


def main(arguments: list[str]) -> int:
    """Run a verb and return its exit code: 0, 2 after an error that was told in one sentence, 130 after Ctrl-C."""
    try:
        # Blender's own handler would set a flag that nobody here looks at.
        with _handling(signal.SIGINT, signal.default_int_handler):
            return _run(arguments)
    except S2agError as error:
        _say(str(error) if not isinstance(error, Cancelled) else "cancelled.")
        return FAILED
    except KeyboardInterrupt:
        _say("interrupted.")
        return INTERRUPTED
    except SystemExit as leaving:  # --help and wrong options
        return int(leaving.code or 0)


def _run(arguments: list[str]) -> int:
    if arguments[:1] == ["setup"]:
        return _setup(arguments[1:])
    if not arguments or arguments[0] in ("-h", "--help"):
        print("In Blender also: s2ag setup, which makes the engine's Python environment (s2ag setup --help)\n", flush=True)
    return _verb(arguments or ["--help"])


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
    python = engine_ops.engine_python(bpy.context)
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONSAFEPATH")}
    if bpy.app.binary_path:
        variables["S2AG_BLENDER"] = bpy.app.binary_path
    process = subprocess.Popen([*client.module_command(python, "core.cli.main"), *arguments], env=variables)
    with _handling(signal.SIGTERM, lambda *_: process.terminate()):
        while True:
            with contextlib.suppress(KeyboardInterrupt):
                return process.wait()


def _setup(arguments: list[str]) -> int:
    options = _parser().parse_args(arguments)
    if options.remove:
        setup.remove(known.folder())
        _say("the engine is removed.")
        return 0
    if options.check:
        _tell(engine_ops.check(bpy.context))
        return 0
    chosen = {"cpu_only": not options.cuda, "recognise": options.recognise}
    plan = setup.plan(known.folder(), options.python, options.wheels, **chosen)
    print(plan.text, flush=True)
    if options.show:
        return 0
    said = None

    def progress(stage: str, value: float) -> None:
        nonlocal said
        if (now := (stage, int(value * 10))) != said:
            said = now
            _say(f"{stage} {int(value * 100)}%" if value else stage)

    _tell(engine_ops.set_up(bpy.context, plan, progress))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="blender --command s2ag setup",
        description="Make the engine's Python environment in the extension's own folder. The registry is only used if "
        "Blender's online access is on (--online-mode turns it on for one run).",
    )
    parser.add_argument("--wheels", metavar="FOLDER", default="", help="install from this folder of wheels, without network")
    parser.add_argument("--python", metavar="PYTHON", default="", help="Python 3.11 to 3.13 that makes the environment")
    parser.add_argument("--cuda", action="store_true", help="on Linux, PyTorch as the registry has it: with CUDA, very large")
    parser.add_argument("--recognise", action="store_true", help="with the speech recogniser, for English without a transcript")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--show", action="store_true", help="only print the commands")
    instead.add_argument("--check", action="store_true", help="only try the engine that is there")
    instead.add_argument("--remove", action="store_true", help="only delete the environment")
    return parser


def _tell(facts: dict) -> None:
    versions = ", ".join(f"{name} {version}" for name, version in facts["packages"].items())
    _say(f"the engine works: {facts['interpreter']}, Python {facts['python']}, {versions}, on {facts['device']}.")


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
