"""Atomic file output, clean-up of temporary files, and logs."""

import contextlib
import hashlib
import itertools
import os
import platform
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

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


def sha256(path: str | os.PathLike) -> str:
    """Return the SHA-256 (hexadecimal) of a file's content; raises OSError."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


MAX_LOGS = 10
"""Number of logs of a kind that are kept."""


_PENDING: set[Path] = set()


_SWEPT: set[Path] = set()
_MAX_TRIES = 50
TEMPORARY_PREFIX = ".s2ag@"
"""Prefix of temporary files; host, process id and a random part follow, separated by ``@``."""


def delete_unfinished() -> None:
    """Delete all temporary files of this process before it exits.

    Repeats while files exist, because other threads may still be writing.
    """
    for _ in range(_MAX_TRIES):
        for temporary in list(_PENDING):
            remove(temporary)
        if not any(temporary.exists() for temporary in list(_PENDING)):
            break


@contextlib.contextmanager
def temporary_folder(parent: str | os.PathLike) -> Iterator[Path]:
    """Yield a hidden temporary folder in ``parent`` and delete it at the end. Raises OSError."""
    delete_leftovers(Path(parent))
    folder = Path(tempfile.mkdtemp(dir=parent, prefix=_prefix()))
    _PENDING.add(folder)
    try:
        yield folder
    finally:
        _PENDING.discard(folder)
        remove(folder)


def delete_leftovers(folder: Path) -> None:
    """Delete temporary files of dead processes of this machine from ``folder``, once per folder and process."""
    if folder in _SWEPT:
        return
    _SWEPT.add(folder)
    for leftover in folder.glob(f"{TEMPORARY_PREFIX}{host_name()}@*@*"):
        pid = leftover.name.split("@")[2]
        if pid.isdecimal() and not is_running(int(pid)):
            remove(leftover)


def host_name() -> str:
    """Return this machine's name in letters, digits and hyphens."""
    return "".join(letter if letter.isalnum() else "-" for letter in platform.node()) or "host"


def is_running(pid: int) -> bool:
    """Return whether a process with this id runs; always True on Windows, which has no harmless way to ask."""
    if os.name == "nt":
        return True
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return not _has_ended(pid)


def _has_ended(pid: int) -> bool:
    """Return whether a process is a zombie, on Linux."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] in "ZX"
    except (OSError, IndexError):
        return False


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` with the same suffix; move it into place on success, delete it on failure.

    Raises :class:`OutputUnwritable` on file system errors (no folder, no permission, full disk).
    """
    path = check_output(path)
    try:
        delete_leftovers(path.parent)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=_prefix(), suffix=path.suffix)
        os.close(handle)
    except OSError as error:
        raise _unwritable(path, error) from error
    temporary = Path(name)
    _PENDING.add(temporary)
    try:
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        _PENDING.discard(temporary)
        remove(temporary)


def _prefix() -> str:
    return f"{TEMPORARY_PREFIX}{host_name()}@{os.getpid()}@"


def remove(path: Path) -> None:
    """Delete a file or a folder, if it exists."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _unwritable(path: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"{path} cannot be written: {error.strerror or error}.", "Free space or choose another folder.")


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
