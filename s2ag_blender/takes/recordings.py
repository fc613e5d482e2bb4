"""Which recording a file holds, told by what is in it: recorders write over their last file, and copies get other dates."""

import hashlib
import time
from functools import lru_cache
from pathlib import Path

_PART = 1 << 20
"""Bytes of the beginning, the middle and the end of a file that it is known by: an hour of sound is not read at once."""
_FRESH = 0.5
_seen: dict[str, tuple[float, str]] = {}


def mark(path: str) -> str:
    """What a file holds, as a short text; empty where it is not there. Cheap enough to draw."""
    looked, found = _seen.get(path, (-_FRESH, ""))
    if time.monotonic() - looked > _FRESH:
        if len(_seen) > 32:
            _seen.clear()
        found = _looked_at(path)
        _seen[path] = time.monotonic(), found
    return found


def differs(path: str, known) -> bool:
    """Whether a file that was ``known`` by its :func:`mark` holds something else by now; False where either is not known."""
    now = mark(path) if isinstance(known, str) and known else ""
    return now != "" and now != known


def _looked_at(path: str) -> str:
    try:
        state = Path(path).stat()
        return _content(path, state.st_size, state.st_mtime_ns)
    except OSError:  # gone, or out of reach: whoever needs it says so
        return ""


@lru_cache(maxsize=32)
def _content(path: str, size: int, written: int) -> str:
    digest = hashlib.sha256(str(size).encode())
    with open(path, "rb") as file:
        for start in sorted({0, max(size // 2 - _PART // 2, 0), max(size - _PART, 0)}):
            file.seek(start)
            digest.update(file.read(_PART))
    return digest.hexdigest()[:16]
