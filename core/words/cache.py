"""Caches slow results as small JSON files in a folder of bounded size; keys are hashes of all inputs."""

import contextlib
import hashlib
import json
import os
from pathlib import Path
from typing import Any

from .. import json_text, user_folders
from ..errors import OutputUnwritable
from ..files import atomic_file

MAX_BYTES = 64_000_000
"""Maximum bytes; the least recently used files are deleted first. An hour of speech takes half a megabyte."""
ENVIRONMENT_VARIABLE = "S2AG_CACHE"
"""Environment variable that names another folder, or ``off``."""


def default_folder() -> Path | None:
    """Return the folder that :data:`ENVIRONMENT_VARIABLE` names, else the platform's cache folder; None to cache nothing."""
    setting = os.environ.get(ENVIRONMENT_VARIABLE, "").strip()
    if setting.lower() == "off":
        return None
    if setting:
        return Path(setting)
    try:
        return user_folders.cache() / "words"
    except RuntimeError:  # the user of this process has no home
        return None


class Cache:
    """Cache in a folder that is created on first use; with ``folder`` None nothing is stored.

    A write that fails raises nothing: :attr:`warning` then holds a sentence for the user."""

    def __init__(self, folder: str | os.PathLike | None, limit: int = MAX_BYTES):
        self.folder = None if folder is None else Path(folder)
        self._limit = limit
        self.warning = ""

    def get(self, key: str) -> Any:
        """Return the JSON value of a key, or None."""
        if self.folder is None:
            return None
        path = self._path(key)
        try:
            value, seal = json_text.read(path, self._limit)
        except (OSError, ValueError, TypeError):  # missing or damaged: the caller computes it again
            return None
        if seal != cache_key(key, value):  # damaged, edited, or of another key
            return None
        with contextlib.suppress(OSError):  # another process may just have deleted it
            os.utime(path)
        return value

    def put(self, key: str, value: Any) -> None:
        """Store a JSON value, and delete the least recently used ones if the cache exceeds its limit."""
        if self.folder is None:
            return
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with atomic_file(self._path(key)) as temporary:
                temporary.write_text(json.dumps([value, cache_key(key, value)], separators=(",", ":")), encoding="utf-8")
        except (OSError, OutputUnwritable) as error:
            why = getattr(error, "strerror", None) or error
            self.warning = f"Word times cannot be kept for the next time in {self.folder} ({why})."
            return
        self._trim()

    def size(self) -> tuple[int, int]:
        """Return the number of files and of bytes."""
        files = self._files()
        return len(files), sum(size for _, size, _ in files)

    def clear(self) -> int:
        """Delete all files; return how many."""
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
        """Return time of last use, bytes and path of all files."""
        files = []
        for path in self.folder.glob("*.words.json") if self.folder and self.folder.is_dir() else ():
            with contextlib.suppress(OSError):  # another process may just have deleted it
                state = path.stat()
                if not path.is_dir():
                    files.append((state.st_mtime, state.st_size, path))
        return files

    def _path(self, key: str) -> Path:
        assert self.folder is not None
        return self.folder / f"{key}.words.json"


def cache_key(*parts: Any) -> str:
    """Return a file name, a hash of these JSON values."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:40]
