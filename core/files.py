"""Files appear whole or not at all."""

import contextlib
import hashlib
import itertools
import os
import platform
import shutil
import tempfile
import time
from pathlib import Path

from .errors import OutputUnwritable


def check_output(path: str | os.PathLike) -> Path:
    """Return ``path`` if something can be written there, else raise :class:`OutputUnwritable` before any work is done."""
    path = Path(path)
    if not path.parent.is_dir():
        raise OutputUnwritable(f"The folder {path.parent} does not exist.", "Create it, or name another output.")
    if path.is_dir():
        raise OutputUnwritable(f"{path} is a folder.", "Name a file inside it.")
    if not os.access(path.parent, os.W_OK):
        raise OutputUnwritable(f"The folder {path.parent} cannot be written to.", "Choose another folder.")
    return path


def sha256(path: str | os.PathLike) -> str:
    """SHA-256 (hexadecimal) of what a file holds; raises OSError."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


LOGS = 10
"""Logs of a kind that are kept."""


_PENDING: set[Path] = set()


_SWEPT: set[Path] = set()
_TRIES = 50
MARK = ".s2ag@"
"""How names of unfinished files begin; host, process and a random part follow, each after an ``@``."""


def abandon() -> None:
    """Delete everything that is not finished: the last act of a process that is told to end.

    Other threads may still write while it goes on, so that what they put there is deleted, too.
    """
    for _ in range(_TRIES):
        for temporary in list(_PENDING):
            remove(temporary)
        if not any(temporary.exists() for temporary in list(_PENDING)):
            break


@contextlib.contextmanager
def part_folder(parent: str | os.PathLike):
    """Yield a hidden folder in ``parent`` for files that are not finished; it is gone in the end. Raises OSError."""
    sweep(Path(parent))
    folder = Path(tempfile.mkdtemp(dir=parent, prefix=_prefix()))
    _PENDING.add(folder)
    try:
        yield folder
    finally:
        _PENDING.discard(folder)
        remove(folder)


def sweep(folder: Path) -> None:
    """Delete what processes of this machine that are gone have left unfinished in ``folder``; looks there once a process."""
    if folder in _SWEPT:
        return
    _SWEPT.add(folder)
    for left in folder.glob(f"{MARK}{host()}@*@*"):
        number = left.name.split("@")[2]
        if number.isdecimal() and not is_running(int(number)):
            remove(left)


def host() -> str:
    """This machine's name in letters and digits."""
    return "".join(letter if letter.isalnum() else "-" for letter in platform.node()) or "host"


def is_running(pid: int) -> bool:
    """Whether a process of that number runs here; always on Windows, which has no way of asking that harms nobody."""
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
    """Whether a process has ended and only waits for its parent to hear of it, where Linux tells."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] in "ZX"
    except (OSError, IndexError):
        return False


@contextlib.contextmanager
def whole_file(path: str | os.PathLike):
    """Yield a temporary path beside ``path`` with the same suffix; move it into place on success, delete it on failure.

    Raises :class:`OutputUnwritable` where the file system refuses (no folder, no permission, full disk).
    """
    path = check_output(path)
    try:
        sweep(path.parent)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=_prefix(), suffix=path.suffix)
        os.close(handle)
    except OSError as error:
        raise _refused(path, error) from error
    temporary = Path(name)
    _PENDING.add(temporary)
    try:
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        raise _refused(path, error) from error
    finally:
        _PENDING.discard(temporary)
        remove(temporary)


def _prefix() -> str:
    return f"{MARK}{host()}@{os.getpid()}@"


def remove(path: Path) -> None:
    """Delete a file or a folder that may be gone already."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"{path} cannot be written: {error.strerror or error}.", "Free space or choose another folder.")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def new_log(folder: Path, kind: str) -> Path:
    """A name for a new log in ``folder``, whose oldest logs of that kind are deleted."""
    for old in sorted(folder.glob(f"{kind}-*.log"))[: 1 - LOGS]:
        old.unlink(missing_ok=True)
    stem = f"{kind}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = (folder / f"{stem}{f'-{number}' if number else ''}.log" for number in itertools.count())
    return next(name for name in names if not name.exists())
