"""``s2ag evaluate --capture``: how near motions captured from films are to those that were filmed."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError
from . import blender
from .progress import Progress, note


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    films = (
        "film known motions of three characters, or of every --character, with three cameras in two lights, capture them, and "
        "compare; the films stay in --report; with --choosing films other motions, of people made by chance and every "
        "--character, from everywhere, and learns from that what the estimator gets wrong"
    )
    parser.add_argument("--capture", action="store_true", help=films)


def run(options: argparse.Namespace, people: Sequence[Path]) -> int:
    """Film, capture, print the table, and write it to the report."""
    from ..files import atomic_file
    from ..learning.capture import filmed, lessons, trial

    if options.report is None:
        raise UsageError("--report is required.", "Name the folder for films and table.")
    if not people:
        raise UsageError("No recording was given.", "Name one with --human.")
    blender.command("render.job")  # raise errors now, not after the synthesis
    others = [(who, "female") for who in options.character]
    with Progress() as progress:
        if options.choosing:
            print(lessons.learn(options.report, people, others, blender.run, progress))
            return 0
        page = trial.run(options.report, people, others or filmed.CHARACTERS, blender.run, progress)
    print(page)
    with atomic_file(options.report / "capture.md") as temporary:
        temporary.write_text(page + "\n", "utf-8")
    note(f"{options.report / 'capture.md'} is written.")
    return 0
