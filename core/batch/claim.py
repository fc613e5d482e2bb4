"""Two batches never work on the same clips of one folder at once: a lock of the system, which goes with its process."""

import contextlib
import json
import os
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from .. import json_text
from ..errors import OutputUnwritable
from ..files import host

_PATIENCE = 10.0
"""Seconds that another process may take to look around, at most."""
_BEYOND = 1 << 30
"""Where in a file Windows locks a byte: what is locked there cannot be read."""


@contextlib.contextmanager
def claim(root: Path, stages: Iterable[str], names: Iterable[str]) -> Iterator[None]:
    """Hold the clips ``names`` of the batch in the folder ``root`` for ``stages``.

    Raises :class:`OutputUnwritable` where a living process holds one of them; what dead ones have held is free. Where the
    file system knows no locks nothing is held. Slices of a farm, which share no clip, do not meet.
    """
    locks = root / ".locks"
    stages, names = sorted(stages), sorted(names)
    locks.mkdir(parents=True, exist_ok=True)
    with _door(locks / "door"):
        for other in sorted(locks.glob("*.json")):
            _step_aside(other, root, set(stages), set(names))
        handle, mine = tempfile.mkstemp(dir=locks, prefix=f"{host()}@{os.getpid()}@", suffix=".json")
        _try_lock(handle)
        content = {"host": host(), "process": os.getpid(), "stages": stages, "names": names}
        os.write(handle, json.dumps(content).encode())
    try:
        yield
    finally:
        os.close(handle)
        Path(mine).unlink(missing_ok=True)


def _step_aside(other: Path, root: Path, stages: set[str], names: set[str]) -> None:
    """Raise where another process holds what we want; take away what a dead one has left."""
    try:
        handle = os.open(other, os.O_RDWR)
    except OSError:
        return  # it has just ended
    try:
        alive = _try_lock(handle) is False
        held = _held(other) if alive else {}
    finally:
        os.close(handle)
    if not alive:
        other.unlink(missing_ok=True)
    elif stages & set(held.get("stages", stages)) and names & set(held.get("names", names)):
        who = f"process {held.get('process', '?')} on {held.get('host', '?')}"
        raise OutputUnwritable(f"Another s2ag batch is at work in {root} ({who}).", "Wait for its end, or name another folder.")


def _held(path: Path) -> dict:
    """What a lock's owner says it holds; {}, which means everything, where it says nothing sensible."""
    try:
        content = json_text.read(path)
    except (OSError, ValueError):
        return {}
    lists = isinstance(content, dict) and all(isinstance(content.get(name), list) for name in ("stages", "names"))
    texts = lists and all(isinstance(one, str) for name in ("stages", "names") for one in content[name])
    return content if texts else {}


@contextlib.contextmanager
def _door(path: Path) -> Iterator[None]:
    """One process at a time looks at the locks and adds its own."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    end = time.monotonic() + _PATIENCE
    try:
        while _try_lock(handle) is False and time.monotonic() < end:
            time.sleep(0.02)
        yield
    finally:
        os.close(handle)


def _try_lock(handle: int) -> bool | None:
    """Whether the file is ours now, None where the file system knows no locks."""
    try:
        if os.name == "nt":
            import msvcrt

            os.lseek(handle, _BEYOND, os.SEEK_SET)
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
            os.lseek(handle, 0, os.SEEK_SET)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        return None
    return True
