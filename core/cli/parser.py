"""The options of all commands."""

import argparse

from ..version import VERSION
from . import animate, batch, bench, checkpoint, data, doctor, edit, engine, evaluate, rig, sample, study, styles, synth
from .parsing import Parser


def parser() -> Parser:
    """The parser of ``s2ag`` and all its verbs; what it gives has ``run``, which takes it."""
    made = Parser(
        prog="s2ag",
        description="A voice goes in, a gesturing character comes out.",
        epilog="example:\n  s2ag animate voice.mp3 --character human -o talk.mp4",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--version", action="version", version=f"s2ag {VERSION}")
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for verb in (synth, animate, edit, sample, batch, rig, styles, doctor, engine, evaluate, bench, checkpoint, data, study):
        name = verb.__name__.rpartition(".")[2]
        command = commands.add_parser(
            name,
            help=verb.SUMMARY,
            description=verb.SUMMARY[0].upper() + verb.SUMMARY[1:] + ".",
            epilog=verb.EXAMPLE,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        verb.configure(command)
        command.set_defaults(run=verb.run)
    return made
