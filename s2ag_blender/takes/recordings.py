"""Identifies recordings by a hash of their content, since recorders overwrite files and copies get new dates."""

import hashlib
import time
from functools import lru_cache
from pathlib import Path

_PART_BYTES = 1 << 20
"""Bytes at the beginning, middle and end of a file that are hashed; reading an hour of sound would take too long."""
_CACHE_SECONDS = 0.5
"""Seconds for which a hash is reused without looking at the file."""
_cache: dict[str, tuple[float, str]] = {}


def content_mark(path: str) -> str:
    """Return a hash of a file's content, "" if it does not exist. Fast enough for drawing."""
    checked, digest = _cache.get(path, (-_CACHE_SECONDS, ""))
    if time.monotonic() - checked > _CACHE_SECONDS:
        if len(_cache) > 32:
            _cache.clear()
        digest = _hash_file(path)
        _cache[path] = time.monotonic(), digest
    return digest


def differs(path: str, known: object) -> bool:
    """Return whether a file's :func:`content_mark` differs from the ``known`` one; False if either is missing."""
    now = content_mark(path) if isinstance(known, str) and known else ""
    return now != "" and now != known


def _hash_file(path: str) -> str:
    try:
        state = Path(path).stat()
        return _content(path, state.st_size, state.st_mtime_ns)
    except OSError:  # callers report missing files
        return ""


@lru_cache(maxsize=32)
def _content(path: str, size: int, written: int) -> str:
    digest = hashlib.sha256(str(size).encode())
    with open(path, "rb") as file:
        for start in sorted({0, max(size // 2 - _PART_BYTES // 2, 0), max(size - _PART_BYTES, 0)}):
            file.seek(start)
            digest.update(file.read(_PART_BYTES))
    return digest.hexdigest()[:16]
