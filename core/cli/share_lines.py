"""How much of a verb's work is done as lines of stderr, for programs that wait for it: ``37%``."""

import argparse
import sys
from typing import Self

from .progress import Progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument("--shares", action="store_true", help="print how much is done as lines of N%%, for programs")


def chosen(options: argparse.Namespace, stage: str) -> "Progress | ShareLines":
    """Return what the verb reports its progress to: a bar, or lines for the share that is done of ``stage``."""
    return ShareLines(stage) if options.shares else Progress()


class ShareLines:
    """Prints the whole percentages of a stage, each once; called as :class:`Progress` is."""

    def __init__(self, stage: str):
        self._stage, self._percent = stage, -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __call__(self, stage: str, value: float) -> None:
        percent = int(100 * min(value, 1.0))
        if stage == self._stage and percent > self._percent:
            self._percent = percent
            print(f"{percent}%", file=sys.stderr, flush=True)
