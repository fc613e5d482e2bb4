"""Tries inputs at doors: ``python tests/fuzz/serve.py DOOR FIRST COUNT`` prints a line of JSON for each that falls.

Lines of standard input, ``DOOR FIRST COUNT``, do where nothing is named; each is answered by a last line ``{"done": ...}``. An
input falls that ends in anything but a result or an error with two sentences, that takes more than :data:`SECONDS` of CPU,
or after which the process has needed more than :data:`BYTES` beyond what it began with.
"""

import contextlib
import faulthandler
import importlib.util
import json
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

import doors
import mutations
from door import Door
from s2ag.core.errors import S2agError

if importlib.util.find_spec("torch"):
    import networks  # noqa: F401 (its doors stand beside the others)

SECONDS, BYTES = 10.0, 600_000_000
STUCK = 60
"""Seconds after which an input is held to hang, on a machine that others use, too."""


def peak() -> int:
    """Bytes that this process has held at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1000


def attempt(door: Door, number: int, folder: Path, began: int) -> tuple[str, bool]:
    """What is wrong with how an input ended, "" for nothing, and whether it ended in a result."""
    suffix, data = mutations.damaged(number, door.name, door.seeds(), door.damage)
    path = folder / f"input{suffix}"
    path.write_bytes(data)
    started, wrong, result = time.process_time(), "", False
    try:
        door.use(path)
        result = True
    except S2agError as error:
        told = error.message, error.remedy
        if not all(text and text.isprintable() and len(text) < 2000 for text in told):
            wrong = f"its sentences are {told!r}"
    except BaseException:  # what else may come out of a door is what is looked for
        wrong = traceback.format_exc(limit=-8)
    spent = time.process_time() - started
    if spent > SECONDS:
        wrong += f"it took {spent:.1f} s"
    if peak() - began > BYTES:
        wrong += f"it took {(peak() - began) / 1e6:.0f} MB"
    for left in folder.iterdir():
        if left.is_file():
            left.unlink()
    return wrong, result


def try_door(name: str, first: int, count: int, tell) -> None:
    """Inputs ``first`` to ``first + count`` of a door, one after the other."""
    door = doors.DOORS[name]
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder)
        with contextlib.suppress(S2agError):
            door.use(door.valid(own))  # what is loaded once is loaded now
        began, longest, results = peak(), 0.0, 0
        for number in range(first, first + count):
            faulthandler.dump_traceback_later(STUCK, exit=True)
            started = time.process_time()
            wrong, result = attempt(door, number, own, began)
            results += result
            longest = max(longest, time.process_time() - started)
            if wrong:
                tell({"door": name, "number": number, "wrong": wrong})
                began = max(began, peak() - BYTES)
        faulthandler.cancel_dump_traceback_later()
        figures = {"seconds": round(longest, 2), "megabytes": round((peak() - began) / 1e6)}
        tell({"done": name, "tried": count, "results": results, **figures})


def main() -> None:
    """Serve the arguments, or standard input to its end."""
    warnings.simplefilter("error", RuntimeWarning)
    limit = 6 << 30  # of addresses, most of which is never touched: a bomb ends here and not with the machine
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    replies = os.dup(1)
    os.dup2(2, 1)

    def tell(message: dict) -> None:
        os.write(replies, json.dumps(message).encode() + b"\n")

    with tempfile.TemporaryDirectory() as home, contextlib.chdir(home):
        for line in [" ".join(sys.argv[1:])] if sys.argv[1:] else sys.stdin:
            name, first, count = line.split()
            try_door(name, int(first), int(count), tell)


if __name__ == "__main__":
    main()
