"""Locks the clips of a batch so that no two batches process the same ones; the system frees the lock when a process ends."""

import contextlib
import json
import os
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from .. import json_text
from ..errors import OutputUnwritable
from ..files import host_name
from ..locks import try_lock

_DOOR_TIMEOUT = 10.0
"""Seconds to wait at most while another process checks the locks."""


@contextlib.contextmanager
def lock_clips(root: Path, stages: Iterable[str], names: Iterable[str]) -> Iterator[None]:
    """Lock the clips ``names`` of the batch in the folder ``root`` for ``stages``.

    Raises :class:`OutputUnwritable` if a running process holds one of them; locks of ended processes are removed. On a file
    system without locks nothing is locked. Slices of a farm, which share no clip, do not conflict.
    """
    locks = root / ".locks"
    stages, names = sorted(stages), sorted(names)
    locks.mkdir(parents=True, exist_ok=True)
    with _door(locks / "door"):
        for other in sorted(locks.glob("*.json")):
            _check_lock(other, root, set(stages), set(names))
        handle, own_lock = tempfile.mkstemp(dir=locks, prefix=f"{host_name()}@{os.getpid()}@", suffix=".json")
        try_lock(handle)
        content = {"host": host_name(), "process": os.getpid(), "stages": stages, "names": names}
        os.write(handle, json.dumps(content).encode())
    try:
        yield
    finally:
        os.close(handle)
        Path(own_lock).unlink(missing_ok=True)


def _check_lock(lock: Path, root: Path, stages: set[str], names: set[str]) -> None:
    """Raise :class:`OutputUnwritable` if a running process holds one of these clips; delete the lock of an ended one."""
    try:
        handle = os.open(lock, os.O_RDWR)
    except OSError:
        return  # its process has just ended
    try:
        alive = try_lock(handle) is False
        held = _read_lock(lock) if alive else {}
    finally:
        os.close(handle)
    if not alive:
        lock.unlink(missing_ok=True)
    elif stages & set(held.get("stages", stages)) and names & set(held.get("names", names)):
        who = f"process {held.get('process', '?')} on {held.get('host', '?')}"
        raise OutputUnwritable(f"Another s2ag batch is at work in {root} ({who}).", "Wait for its end, or name another folder.")


def _read_lock(path: Path) -> dict:
    """Return the content of a lock; {}, which means that it holds everything, if it is invalid."""
    try:
        content = json_text.read(path)
    except (OSError, ValueError):
        return {}
    lists = isinstance(content, dict) and all(isinstance(content.get(name), list) for name in ("stages", "names"))
    texts = lists and all(isinstance(item, str) for name in ("stages", "names") for item in content[name])
    return content if texts else {}


@contextlib.contextmanager
def _door(path: Path) -> Iterator[None]:
    """Let one process at a time check the locks and add its own."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    end = time.monotonic() + _DOOR_TIMEOUT
    try:
        while try_lock(handle) is False and time.monotonic() < end:
            time.sleep(0.02)
        yield
    finally:
        os.close(handle)
