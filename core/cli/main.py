"""The command ``s2ag``: parsing, and the one place that turns errors into a sentence and an exit status."""

import argparse
import contextlib
import os
import signal
import sys

from ..errors import EngineMissing, S2agError, UsageError
from ..version import VERSION
from . import animate, batch, bench, checkpoint, data, doctor, evaluate, rig, sample, study, styles, synth
from .progress import say

FAILED = 2
INTERRUPTED = 130


class Parser(argparse.ArgumentParser):
    """argparse, whose complaints are one sentence like all others."""

    def error(self, message):
        raise UsageError(f"{message[:1].upper()}{message[1:]}.", f"See: {self.prog} --help")


def main(argv: list[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, 2 after an error that was told on stderr, 130 after Ctrl-C."""
    if argv is None:
        # Leave through the same doors as Ctrl-C, so that a farm's kill also removes temporary files and child processes.
        for name in ("SIGTERM", "SIGHUP"):
            if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) != signal.SIG_IGN:  # as nohup wants it
                signal.signal(getattr(signal, name), signal.default_int_handler)
    try:
        options = _parser().parse_args(argv)
        return options.run(options)
    except SystemExit as leaving:  # --help and --version
        return int(leaving.code or 0)
    except S2agError as error:
        say(f"{error}" if error.kind != "Cancelled" else "cancelled.")
        return FAILED
    except KeyboardInterrupt:
        say("interrupted.")
        return INTERRUPTED
    except ModuleNotFoundError as error:
        say(f"{EngineMissing.of(error)}")
        return FAILED
    except BrokenPipeError:
        # The reader of our output has enough; without this Python complains again while it ends.
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return FAILED
    except OSError as error:
        say(f"{error.filename or 'A file'} failed: {error.strerror or error}. Check the path and the free space.")
        return FAILED
    except Exception as error:
        if os.environ.get("S2AG_DEBUG"):
            raise
        say(f"this is a mistake in s2ag ({type(error).__name__}: {error}). Please report it; S2AG_DEBUG=1 shows where.")
        return FAILED


def _parser() -> Parser:
    parser = Parser(
        prog="s2ag",
        description="A voice goes in, a gesturing character comes out.",
        epilog="example:\n  s2ag animate voice.mp3 --character human -o talk.mp4",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"s2ag {VERSION}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for verb in (synth, animate, sample, batch, rig, styles, doctor, evaluate, bench, checkpoint, data, study):
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
    return parser


if __name__ == "__main__":
    sys.exit(main())
