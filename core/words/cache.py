"""Results that cost seconds, kept by a hash of all they were made from: small JSON files in one folder of bounded size."""

import contextlib
import hashlib
import json
import os
import sys
from pathlib import Path

from .. import json_text
from ..errors import OutputUnwritable
from ..files import whole_file

LIMIT = 64_000_000
"""Bytes kept; the least recently used go first. An hour of speech takes half a megabyte."""
VARIABLE = "S2AG_CACHE"
"""Environment variable with another folder, or ``off``."""


def default_folder() -> Path | None:
    """Where the platform wants such files, or what :data:`VARIABLE` says; None for nowhere."""
    named = os.environ.get(VARIABLE, "").strip()
    if named.lower() == "off":
        return None
    if named:
        return Path(named)
    try:
        return _users() / "words"
    except RuntimeError:  # nobody's process: it has no home
        return None


def _users() -> Path:
    """The user's folder for what can be made again, where each platform wants it."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "s2ag" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "s2ag"
    named = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(named) if os.path.isabs(named) else Path.home() / ".cache") / "s2ag"


class Cache:
    """A folder of results, made when something is first kept; with ``folder`` None nothing is kept.

    :attr:`trouble` is a sentence once something could not be written; work goes on without it.
    """

    def __init__(self, folder: str | os.PathLike | None, limit: int = LIMIT):
        self.folder = None if folder is None else Path(folder)
        self._limit = limit
        self.trouble = ""

    def get(self, key: str):
        """What was kept under this key, or None."""
        if self.folder is None:
            return None
        path = self._path(key)
        try:
            value = json_text.read(path, self._limit)
        except (OSError, ValueError):  # never kept, or damaged: it is made again
            return None
        with contextlib.suppress(OSError):  # another process may just have cleared it
            os.utime(path)
        return value

    def put(self, key: str, value) -> None:
        """Keep something that is JSON, and forget what was used least recently if there is too much."""
        if self.folder is None:
            return
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with whole_file(self._path(key)) as temporary:
                temporary.write_text(json.dumps(value, separators=(",", ":")), encoding="utf-8")
        except (OSError, OutputUnwritable) as error:
            why = getattr(error, "strerror", None) or error
            self.trouble = f"Word times cannot be kept for the next time in {self.folder} ({why})."
            return
        self._trim()

    def size(self) -> tuple[int, int]:
        """Files and bytes kept."""
        files = self._files()
        return len(files), sum(size for _, size, _ in files)

    def clear(self) -> int:
        """Forget everything; how many files that were."""
        files = self._files()
        for _, _, path in files:
            path.unlink(missing_ok=True)
        return len(files)

    def _trim(self) -> None:
        files = sorted(self._files())
        total = sum(size for _, size, _ in files)
        for _, size, path in files[:-1]:
            if total <= self._limit:
                break
            path.unlink(missing_ok=True)
            total -= size

    def _files(self) -> list[tuple[float, int, Path]]:
        found = []
        for path in self.folder.glob("*.words.json") if self.folder and self.folder.is_dir() else ():
            with contextlib.suppress(FileNotFoundError):
                state = path.stat()
                found.append((state.st_mtime, state.st_size, path))
        return found

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.words.json"


def key(*parts) -> str:
    """A name for what follows from these JSON values."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:40]
