"""What the command line says on stderr: notes, the one sentence of an error, and a bar on a terminal."""

import shutil
import sys
import time

from ..errors import readable

_WIDTH = 40


def say(sentence: str) -> None:
    """One line on stderr, marked as ours."""
    print(f"s2ag: {readable(' '.join(sentence.split()))}", file=sys.stderr)


def note(sentence: str) -> None:
    """A warning or something worth knowing; work goes on."""
    say(f"note: {sentence}")


class Progress:
    """A progress bar, called with a stage and a value of 0..1 within it; silent unless stderr is a terminal.

    Values that do not go forward within a stage are ignored. Use as a context manager, so that the bar is gone before
    anything else is printed.
    """

    def __init__(self):
        self._shown, self._stage, self._percent, self._began = False, None, 0, 0.0

    def __enter__(self):
        self._shown = sys.stderr is not None and sys.stderr.isatty()
        return self

    def __exit__(self, *_):
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
        # Some terminals claim to have no columns at all; the standard library then says 80.
        width = shutil.get_terminal_size().columns - 1
        sys.stderr.write(f"\r{' ' * width}\r{line[:width]}")
        sys.stderr.flush()


class TimeLeft:
    """Progress of a batch, called with ``(stage, share, finished, total)``: a bar with the time left on a terminal.

    With ``openjd``, lines on standard output that a farm of Open Job Description understands.
    """

    def __init__(self, openjd: bool = False):
        self._openjd, self._told = openjd, -1
        self._bar = Progress()
        self._stage, self._began = "", 0.0

    def __enter__(self):
        self._bar.__enter__()
        return self

    def __exit__(self, *_):
        self._bar.__exit__()

    def __call__(self, stage: str, share: float, finished: int, total: int) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began, self._told = stage, now, -1
        left = (now - self._began) * (1 - share) / share if share else 0.0
        told = f"{stage} {finished}/{total}, {clock(left)} left"
        self._bar(told, share)
        if self._openjd and (percent := int(100 * share)) > self._told:
            self._told = percent
            print(f"openjd_progress: {percent}\nopenjd_status: {told}", flush=True)


def clock(seconds: float) -> str:
    """``0:07``, ``12:30`` or ``1:02:03``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
