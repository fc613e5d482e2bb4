"""A warm engine's memory: the last recording heard and the last performance, so that another style or size costs less."""

from pathlib import Path
from typing import Any

from ..settings import Settings, names_with, table


class SessionCache:
    """The last recording as it was heard, and the last performance of it."""

    def __init__(self) -> None:
        self._heard: tuple[Any, Any] = (None, None)
        self._made: tuple[Any, Any] = (None, None)

    def heard(self, recording: tuple) -> Any:
        """Return what was heard of the recording with this :func:`recording_key`, or None if it was not the last one."""
        return self._heard[1] if self._heard[0] == recording else None

    def made(self, performers: tuple) -> Any:
        """Return what these performers made, or None if they were not the last ones."""
        return self._made[1] if self._made[0] == performers else None

    def keep_heard(self, recording: tuple, heard: Any) -> None:
        """Remember a recording instead of the former one."""
        self._heard = (recording, heard)

    def keep(self, recording: tuple, heard: Any, performers: tuple, made: Any) -> None:
        """Remember a recording and a performance instead of the former ones."""
        self.keep_heard(recording, heard)
        self._made = (performers, made)


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
