"""The parser of the whole command line, with the options of every verb."""

import argparse
import importlib
from collections.abc import Sequence
from typing import NoReturn

from ..errors import UsageError
from ..version import VERSION
from . import animate, styles, synth
from .package_parts import is_whole, require_whole

VERBS = (synth, animate, styles)
"""Modules of the verbs that the Python package and Blender's extension have."""
PACKAGE_VERBS = {
    "edit": "engine",
    "meaning": "engine",
    "idle": "engine",
    "lines": "blender",
    "gestures": "blender",
    "rig": "blender",
    "engine": "full",
    "doctor": "engine",
    "sample": "blender",
    "batch": "blender",
    "evaluate": "train",
    "bench": "train,bench",
    "checkpoint": "full",
    "capture": "engine",
    "learn": "engine",
    "data": "train",
    "study": "engine",
}
"""Verbs of the Python package alone -> the extras that they need. The extension's zip does not contain them."""
_ELSEWHERE = {**PACKAGE_VERBS, "train": "train"}


class Parser(argparse.ArgumentParser):
    """A parser that raises :class:`UsageError` instead of exiting."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message[:1].upper()}{message[1:]}.", f"See: {self.prog} --help")


def require_available(arguments: Sequence[str]) -> None:
    """Raise :class:`UsageError` if the verb is one of the Python package and this is Blender's extension."""
    verb = arguments[0] if arguments else ""
    if verb in _ELSEWHERE:
        require_whole(f"{verb} is a command", _ELSEWHERE[verb])


def parser() -> Parser:
    """Return the parser of ``s2ag`` and all its verbs; the attribute ``run`` of the options is the verb's function."""
    whole = Parser(
        prog="s2ag",
        description="A voice goes in, a gesturing character comes out.",
        epilog="example:\n  s2ag animate voice.mp3 --character human -o talk.mp4",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"s2ag {VERSION}")
    commands = whole.add_subparsers(title="commands", required=True, metavar="COMMAND")
    package_verbs = PACKAGE_VERBS if is_whole() else ()
    for verb in (*VERBS, *(importlib.import_module(f".{name}", __package__) for name in package_verbs)):
        command = commands.add_parser(
            verb.__name__.rpartition(".")[2],
            help=verb.SUMMARY,
            description=verb.SUMMARY[0].upper() + verb.SUMMARY[1:] + ".",
            epilog=verb.EXAMPLE,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        verb.configure(command)
        command.set_defaults(run=verb.run)
    return whole
