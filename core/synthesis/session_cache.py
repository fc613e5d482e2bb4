"""A warm engine's memory: the last recording heard and the last performance, so that another style or size costs less."""

from pathlib import Path
from typing import Any

from ..settings import Settings, names_with, table


class SessionCache:
    """The last recording as it was heard, and the last performance of it, each behind its key."""

    def __init__(self) -> None:
        self.heard: tuple[Any, Any] = (None, None)
        self.made: tuple[Any, Any] = (None, None)


def recalled(kept: tuple[Any, Any], key: tuple) -> Any:
    """Return what was ``kept`` if it has this ``key``, else None."""
    return kept[1] if kept[0] == key else None


def recording_settings(request: Settings) -> tuple[str, ...]:
    """Return the settings that identify a recording and its words, with paths as text."""
    return tuple(str(getattr(request, name)) for name in ("audio", *names_with(recording=True)))


def recording_key(request: Settings) -> tuple:
    """Return what identifies what is heard of a recording, without reading it: settings, and sizes and times of its files."""
    kinds = table(type(request))
    paths = [getattr(request, name) for name in ("audio", *names_with(recording=True, kind="path"))]
    files = [Path(path) for path in paths if path is not None]
    states = [(str(file), state.st_size, state.st_mtime_ns) for file in files if file.is_file() and (state := file.stat())]
    wanted = [getattr(request, name) != kinds[name].default for name in names_with(heard=True)]
    return (*states, len(files), *recording_settings(request), *wanted)
