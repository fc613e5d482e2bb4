"""Locks of files prove that a process lives, wherever it runs: the system frees them when it ends.

Process ids prove nothing between containers and on a share of several machines, which may all have one host name."""

import os
from pathlib import Path

_OFFSET = 1 << 30
"""Offset of the byte that is locked on Windows: beyond the content, because locked bytes cannot be read."""


def try_lock(handle: int) -> bool | None:
    """Return whether the open file ``handle`` could be locked, None on a file system without locks."""
    try:
        if os.name == "nt":
            import msvcrt

            os.lseek(handle, _OFFSET, os.SEEK_SET)
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


def is_held(path: Path) -> bool | None:
    """Return whether a process holds the lock ``path``, None where nobody can know; nobody holds a missing one."""
    try:
        handle = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return False
    except OSError:
        return None
    try:
        free = try_lock(handle)
        return None if free is None else not free
    finally:
        os.close(handle)
