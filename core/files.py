"""Atomic file output, clean-up of temporary files, and logs."""

import contextlib
import errno
import hashlib
import itertools
import os
import platform
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, cast

from . import locks
from .errors import OutputUnwritable


def check_output(path: str | os.PathLike) -> Path:
    """Return ``path`` if it can be written, otherwise raise :class:`OutputUnwritable`; call it before any work is done."""
    path = Path(path)
    if not path.parent.is_dir():
        raise OutputUnwritable(f"The folder {path.parent} does not exist.", "Create it, or name another output.")
    if path.is_dir():
        raise OutputUnwritable(f"{path} is a folder.", "Name a file inside it.")
    if not os.access(path.parent, os.W_OK):
        raise OutputUnwritable(f"The folder {path.parent} cannot be written to.", "Choose another folder.")
    return path


def open_file(path: str | os.PathLike) -> BinaryIO:
    """Open a file for reading; raises OSError, also for pipes and devices, from which nothing may ever come."""
    mode = os.stat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise OSError(errno.EINVAL, "It is a pipe or a device", os.fspath(path))
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0)))  # a pipe by now


def read_bytes(path: str | os.PathLike) -> bytes:
    """Return a file's content; raises OSError as :func:`open_file`."""
    with open_file(path) as file:
        return file.read()


def sha256(path: str | os.PathLike) -> str:
    """Return the SHA-256 (hexadecimal) of a file's content; raises OSError."""
    with open_file(path) as file:
        return hashlib.file_digest(cast(Any, file), "sha256").hexdigest()


MAX_LOGS = 10
"""Number of logs of a kind that are kept."""
_PENDING: set[Path] = set()
_SWEPT: set[Path] = set()
_MAX_TRIES = 50
TEMPORARY_PREFIX = ".s2ag@"
"""Prefix of temporary files; host, process id and a random part follow, separated by ``@``."""
_LOCK = ".lock"
"""Suffix of the file beside them that their process locks."""
_ABANDONED = 86400.0
"""Seconds after which what seems to be nobody's, but may be another machine's, counts as abandoned."""


def delete_unfinished() -> None:
    """Delete all temporary files of this process before it exits.

    Repeats while files exist, because other threads may still be writing."""
    for _ in range(_MAX_TRIES):
        for temporary in list(_PENDING):
            remove(temporary)
        if not any(temporary.exists() for temporary in list(_PENDING)):
            break


@contextlib.contextmanager
def temporary_folder(parent: str | os.PathLike) -> Iterator[Path]:
    """Yield a hidden temporary folder in ``parent`` and delete it at the end. Raises OSError."""
    with _own_name(Path(parent)) as folder:
        folder.mkdir(0o700)
        yield folder


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """Yield a temporary folder in the system's, which is made again where it has vanished. Raises OSError."""
    parent = Path(tempfile.gettempdir())
    parent.mkdir(0o700, parents=True, exist_ok=True)
    with temporary_folder(parent) as folder:
        yield folder


@contextlib.contextmanager
def _own_name(parent: Path, suffix: str = "") -> Iterator[Path]:
    """Yield the path of a temporary file or folder, and hold the lock beside it; delete both at the end. Raises OSError."""
    delete_leftovers(parent)
    while True:
        handle, name = tempfile.mkstemp(dir=parent, prefix=f"{TEMPORARY_PREFIX}{host_name()}@{os.getpid()}@", suffix=_LOCK)
        locks.try_lock(handle)
        if os.path.exists(name):
            break
        os.close(handle)  # another process took it for a leftover before it was locked
    path = Path(f"{name.removesuffix(_LOCK)}{suffix}")
    _PENDING.update((path, Path(name)))
    try:
        yield path
    finally:
        remove(path)
        os.close(handle)
        remove(Path(name))
        _PENDING.difference_update((path, Path(name)))


def delete_leftovers(folder: Path) -> None:
    """Delete temporary files of ended processes from ``folder``, once per folder and process.

    Those of other machines, whose locks may not be seen from here, stay for a day."""
    if folder in _SWEPT:
        return
    _SWEPT.add(folder)
    for leftover in folder.glob(f"{TEMPORARY_PREFIX}*@*@*"):
        machine, pid, rest = leftover.name.removeprefix(TEMPORARY_PREFIX).split("@", 2)
        lock = leftover.with_name(f"{TEMPORARY_PREFIX}{machine}@{pid}@{rest.partition('.')[0]}{_LOCK}")
        held = locks.is_held(lock) if pid.isdecimal() else True
        if (held is False and machine == host_name()) or (not held and _age(leftover) > _ABANDONED):
            remove(leftover)


def _age(path: Path) -> float:
    """Return the seconds since the last change, 0 if ``path`` is missing."""
    try:
        return time.time() - path.stat().st_mtime
    except OSError:
        return 0.0


def host_name() -> str:
    """Return this machine's name in letters, digits and hyphens."""
    return "".join(letter if letter.isalnum() else "-" for letter in platform.node()) or "host"


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` with the same suffix; move it into place on success, delete it on failure.

    Raises :class:`OutputUnwritable` on file system errors (no folder, no permission, full disk)."""
    path = check_output(path)
    try:
        with _own_name(path.parent, path.suffix) as temporary:
            temporary.touch(0o600)
            yield temporary
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
    except OSError as error:
        what = f"{path} cannot be written: {error.strerror or error}."
        raise OutputUnwritable(what, "Free space or choose another folder.") from error


def remove(path: Path) -> None:
    """Delete a file or a folder, if it exists."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def new_log(folder: Path, kind: str) -> Path:
    """Return the path of a new log in ``folder``; deletes the oldest logs of that kind beyond :data:`MAX_LOGS`."""
    for old in sorted(folder.glob(f"{kind}-*.log"))[: 1 - MAX_LOGS]:
        old.unlink(missing_ok=True)
    stem = f"{kind}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = (folder / f"{stem}{f'-{number}' if number else ''}.log" for number in itertools.count())
    return next(name for name in names if not name.exists())
