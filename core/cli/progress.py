"""Output of the command line on stderr: notes, errors, and a progress bar on terminals."""

import shutil
import sys
import time
from typing import Self

from ..errors import sanitize

_WIDTH = 40


def say(sentence: str) -> None:
    """Print a sentence as one line on stderr, with our prefix."""
    print(f"s2ag: {sanitize(' '.join(sentence.split()))}", file=sys.stderr)


def note(sentence: str) -> None:
    """Print a warning or information."""
    say(f"note: {sentence}")


class Progress:
    """A progress bar, called with a stage and its value 0..1; silent unless stderr is a terminal.

    Ignores values that do not increase within a stage. Use as a context manager, which erases the bar at its end."""

    def __init__(self) -> None:
        self._shown, self._stage, self._percent, self._began = False, "", 0, 0.0

    def __enter__(self) -> Self:
        self._shown = sys.stderr is not None and sys.stderr.isatty()
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown:
            self._write("")
            self._shown = False

    def __call__(self, stage: str, value: float) -> None:
        if not self._shown:
            return
        percent = int(100 * min(value, 1.0))
        if stage != self._stage:
            self._stage, self._began = stage, time.monotonic()
        elif percent <= self._percent:
            return
        self._percent = percent
        done = percent * _WIDTH // 100
        bar = "#" * done + " " * (_WIDTH - done)
        self._write(f"{stage:<20}{percent:3d}% |{bar}| {clock(time.monotonic() - self._began)}")

    def _write(self, line: str) -> None:
        # Some terminals report no columns; the standard library then returns 80.
        width = shutil.get_terminal_size().columns - 1
        sys.stderr.write(f"\r{' ' * width}\r{line[:width]}")
        sys.stderr.flush()


def clock(seconds: float) -> str:
    """Return seconds as ``0:07``, ``12:30`` or ``1:02:03``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
