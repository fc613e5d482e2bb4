"""``s2ag evaluate --seated``: whether hands of seated characters stay out of thighs and table, and legs as they were posed."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError
from . import blender
from .progress import Progress

LEAST = 2.0
"""Seconds of the shortest trial."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    text = (
        "measure only how deep hands lie in thighs and table, and whether legs stay, of characters who sit, idle and talk; "
        "with --report their scenes are kept"
    )
    parser.add_argument("--seated", action="store_true", help=text)
    seconds = "seated: seconds of idle and of talk on each --character (default 300; characters mannequin, human:mixamo)"
    parser.add_argument("--seconds", metavar="N", type=float, default=300.0, help=seconds)


def run(options: argparse.Namespace, people: Sequence[Path]) -> int:
    """Print the figures."""
    from ..learning.evaluate import seated

    if not LEAST <= options.seconds <= 3600:
        raise UsageError(f"{options.seconds:g} seconds were asked for.", f"Ask for {LEAST:g} to 3600.")
    blender.command("render.seated_trial")  # raise errors now, not after the synthesis
    if options.report is not None:
        options.report.mkdir(parents=True, exist_ok=True)
    characters = options.character or ["mannequin", "human:mixamo"]
    with Progress() as progress:
        rows = seated.trial(characters, people, blender.run, options.seconds, progress, options.report)
    print(seated.page(rows))
    return 0
