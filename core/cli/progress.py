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

    Ignores values that do not increase within a stage. Use as a context manager, which erases the bar at its end.
    """

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


class TimeLeft:
    """Progress of a batch, called with ``(stage, share, finished, total)``: a bar with the time left on terminals.

    With ``openjd`` it also prints lines of Open Job Description to standard output.
    """

    def __init__(self, openjd: bool = False) -> None:
        self._openjd, self._printed_percent = openjd, -1
        self._bar = Progress()
        self._stage, self._began = "", 0.0

    def __enter__(self) -> Self:
        self._bar.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.__exit__()

    def __call__(self, stage: str, share: float, finished: int, total: int) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began, self._printed_percent = stage, now, -1
        left = (now - self._began) * (1 - share) / share if share else 0.0
        status = f"{stage} {finished}/{total}, {clock(left)} left"
        self._bar(status, share)
        if self._openjd and (percent := int(100 * share)) > self._printed_percent:
            self._printed_percent = percent
            print(f"openjd_progress: {percent}\nopenjd_status: {status}", flush=True)


def clock(seconds: float) -> str:
    """Return seconds as ``0:07``, ``12:30`` or ``1:02:03``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
