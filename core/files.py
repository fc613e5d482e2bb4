"""Files appear whole or not at all."""

import contextlib
import os
import tempfile
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


_PENDING: set[Path] = set()


def abandon() -> None:
    """Delete every file that :func:`whole_file` has not finished: the last act of a process that is told to end."""
    for temporary in list(_PENDING):
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def whole_file(path: str | os.PathLike):
    """Yield a temporary path beside ``path`` with the same suffix; move it into place on success, delete it on failure.

    Raises :class:`OutputUnwritable` where the file system refuses (no folder, no permission, full disk).
    """
    path = check_output(path)
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem[:40]}.", suffix=path.suffix)
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
        temporary.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"{path} cannot be written: {error.strerror or error}.", "Free space or choose another folder.")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
