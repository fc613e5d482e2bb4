"""The folder of a batch: paths of results, records and unfinished work, and atomic placement of results."""

import contextlib
import hashlib
import json
import os
import shutil
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from .. import files, json_text
from ..errors import S2agError
from ..files import atomic_file, sha256

STAGES = ("synth", "render", "encode")


class Folder:
    """Paths below the folder ``root`` of a batch: ``KIND/NAME.suffix`` for results, and those for internal use."""

    def __init__(self, root: str | os.PathLike):
        self.root = Path(root).absolute()

    def result(self, kind: str, name: str, suffix: str = "") -> Path:
        """Return the path of a result; without a suffix it is a folder."""
        return self.root / kind / f"{name}{suffix}"

    def work(self, name: str, kind: str, key: str) -> Path:
        """Return the folder of numbered images until they are complete or encoded; it depends on the render's ``key``."""
        return self.root / ".work" / f"{name}.{kind}.{key[:16]}"

    def works(self, name: str) -> Iterator[Path]:
        """Yield all existing folders of :meth:`tasks` for ``name``."""
        for path in (self.root / ".work").glob(f"{name}.*"):
            if path.name.count(".") == name.count(".") + 2:
                yield path

    def record(self, stage: str, name: str) -> "Record":
        """Return the record of ``stage`` for the clip or scene ``name``."""
        return Record(self, stage, name)

    @property
    def plan(self) -> Path:
        """Path of the manifest with all defaults filled in."""
        return self.root / "plan.jsonl"

    @contextlib.contextmanager
    def part(self) -> Iterator[Path]:
        """Create a temporary folder for unfinished files, on the same file system as the results; deleted at the end."""
        parts = self.root / ".part"
        parts.mkdir(parents=True, exist_ok=True)
        with files.temporary_folder(parts) as temporary:
            yield temporary

    def sweep(self) -> None:
        """Delete unfinished work of ended processes; that of running ones, and recent work of other machines, stays."""
        for left in (self.root / ".part", self.root, self.root / "dataset", *(self.root / "records").glob("*")):
            files.delete_leftovers(left)


class Record:
    """Which files a stage of one clip has made, and a hash of its inputs: a JSON file that is written after the results."""

    def __init__(self, folder: Folder, stage: str, name: str):
        self.folder, self.stage, self.name = folder, stage, name
        self.path = folder.root / "records" / stage / f"{name}.json"
        self.failure_path = folder.root / "records" / f"{stage}-failed" / f"{name}.json"

    def read(self, key: str) -> dict | None:
        """Return the facts of a stage that was made with ``key``; None if it was not, or if a file is missing or changed."""
        content = _read(self.path) or {}
        contents, facts = content.get("files"), content.get("facts")
        if content.get("key") != key or content.get("seal") != _seal(key, contents, facts) or not isinstance(contents, dict):
            return None
        same = (kept is not None and _content(self.folder.root / path) == kept for path, kept in contents.items())
        return facts if all(same) else None

    def write(self, key: str, files: list[Path], facts: dict) -> None:
        """Record that the stage is done, and delete the record of an earlier failure; :class:`S2agError` if a file is gone."""
        contents = {path.relative_to(self.folder.root).as_posix(): _content(path) for path in files}
        if gone := next((path for path, kept in contents.items() if kept is None), None):
            raise S2agError(f"{gone} was deleted while {self.name} was made.", "Run the batch again.", "InputChanged")
        _write(self.path, {"key": key, "files": contents, "facts": facts, "seal": _seal(key, contents, facts)})
        self.failure_path.unlink(missing_ok=True)

    def fail(self, key: str, error: S2agError) -> None:
        """Record why the stage failed."""
        content = {"kind": error.kind, "message": error.message, "remedy": error.remedy}
        _write(self.failure_path, {"key": key, **content})

    def failure(self) -> dict[str, str] | None:
        """Return ``key``, ``kind``, ``message`` and ``remedy`` of the last attempt if it failed; all are strings."""
        content = _read(self.failure_path) or {}
        names = ("key", "kind", "message", "remedy")
        failure = {name: value for name in names if isinstance(value := content.get(name), str)}
        return failure if len(failure) == len(names) else None


def move_to_place(part: Path, place: Path) -> None:
    """Move a finished file or folder from :meth:`Folder.part` to ``place``, replacing what is there."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if part.is_dir() and place.is_dir():
        old = part.with_name(f"{part.name}.old")
        os.replace(place, old)
        os.replace(part, place)
        shutil.rmtree(old, ignore_errors=True)
    else:
        os.replace(part, place)


def content_hash(*content: object) -> str:
    """Return the SHA-256 (hexadecimal) of values that can be JSON."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


_seal = content_hash
"""Checksum of a record's content, which reveals damaged or edited records."""


def digest(path: str | os.PathLike | None) -> str | None:
    """Return the SHA-256 (hexadecimal) of a file's content, None for None; raises OSError."""
    if path is None:
        return None
    status = os.stat(path)
    return _digest(os.fspath(path), status.st_size, status.st_mtime_ns)


@lru_cache(maxsize=4096)
def _digest(path: str, _size: int, _written: int) -> str:
    return sha256(path)


def _read(path: Path) -> dict[str, Any] | None:
    """Return the JSON object in a file, None if it is missing or invalid."""
    try:
        content = json_text.read(path)
    except (OSError, ValueError):
        return None  # missing or invalid: the stage is repeated
    return content if isinstance(content, dict) else None


def _write(path: Path, content: dict) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content, sort_keys=True, indent=1) + "\n", "utf-8")


def _content(path: Path) -> str | None:
    """Return a hash of a file's content, or of all names and contents in a folder; None if there is neither.

    Files that a crash left full of zeros have the sizes that they should have.
    """
    try:
        return content_hash({one.name: digest(one) for one in path.iterdir()}) if path.is_dir() else digest(path)
    except OSError:
        return None
