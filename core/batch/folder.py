"""The folder of a batch: where results, records and half-done work lie, and how results land whole."""

import contextlib
import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from .. import files, json_text
from ..errors import S2agError
from ..files import host, is_running, sha256, whole_file

STAGES = ("synth", "render", "encode")
_ABANDONED = 86400.0
"""Seconds after which half-done work of another machine counts as left behind."""


class Folder:
    """Paths below the folder ``root`` of a batch: ``KIND/NAME.suffix`` for results, and a few of the batch's own."""

    def __init__(self, root: str | os.PathLike):
        self.root = Path(root).absolute()

    def result(self, kind: str, name: str, suffix: str = "") -> Path:
        """Where a result goes; without a suffix it is a folder."""
        return self.root / kind / f"{name}{suffix}"

    def work(self, name: str, kind: str, key: str) -> Path:
        """Where numbered images wait until they are all there, or encoded; other settings have other folders."""
        return self.root / ".work" / f"{name}.{kind}.{key[:16]}"

    def works(self, name: str) -> Iterator[Path]:
        """All folders that :meth:`work` has given for ``name``."""
        for path in (self.root / ".work").glob(f"{name}.*"):
            if path.name.count(".") == name.count(".") + 2:
                yield path

    def record(self, stage: str, name: str) -> "Record":
        """The record of ``stage`` for the clip or scene ``name``."""
        return Record(self, stage, name)

    @property
    def plan(self) -> Path:
        """The manifest in which nothing is left to defaults."""
        return self.root / "plan.jsonl"

    @contextlib.contextmanager
    def part(self):
        """A folder of this process's own for files that are not finished, on the same file system as the results."""
        parts = self.root / ".part"
        parts.mkdir(parents=True, exist_ok=True)
        mine = Path(tempfile.mkdtemp(prefix=f"{host()}@{os.getpid()}@", dir=parts))
        try:
            yield mine
        finally:
            shutil.rmtree(mine, ignore_errors=True)

    def sweep(self) -> None:
        """Delete what killed processes have left half done; work of living processes and of other machines stays."""
        for left in (self.root / ".part").glob("*@*@*"):
            machine, pid, _ = left.name.split("@", 2)
            gone = not is_running(int(pid)) if machine == host() and pid.isdecimal() else _age(left) > _ABANDONED
            if gone:
                shutil.rmtree(left, ignore_errors=True)
        for left in (self.root, self.root / "dataset", *(self.root / "records").glob("*")):
            files.sweep(left)


class Record:
    """What a stage of one clip has made, from what: a small JSON file that lands after the results."""

    def __init__(self, folder: Folder, stage: str, name: str):
        self.folder, self.stage, self.name = folder, stage, name
        self.path = folder.root / "records" / stage / f"{name}.json"
        self.failure_path = folder.root / "records" / f"{stage}-failed" / f"{name}.json"

    def read(self, key: str) -> dict | None:
        """The facts of a finished stage, or None unless it was made from ``key`` and all its files are there."""
        content = _read(self.path) or {}
        made, facts = content.get("files"), content.get("facts")
        if content.get("key") != key or content.get("seal") != _sealed(key, made, facts):
            return None
        return facts if all(_size(self.folder.root / path) == size for path, size in made.items()) else None

    def write(self, key: str, files: list[Path], facts: dict) -> None:
        """Say that the stage is done; a failure of before is forgotten."""
        sizes = {path.relative_to(self.folder.root).as_posix(): _size(path) for path in files}
        _write(self.path, {"key": key, "files": sizes, "facts": facts, "seal": _sealed(key, sizes, facts)})
        self.failure_path.unlink(missing_ok=True)

    def fail(self, key: str, error: S2agError) -> None:
        """Say that and why the stage failed."""
        told = {"kind": error.kind, "message": error.message, "remedy": error.remedy}
        _write(self.failure_path, {"key": key, **told})

    def failure(self) -> dict | None:
        """``key``, ``kind``, ``message`` and ``remedy`` of the last try, if it failed; all are text."""
        told = _read(self.failure_path) or {}
        known = {name: told.get(name) for name in ("key", "kind", "message", "remedy")}
        return known if all(isinstance(value, str) for value in known.values()) else None


def land(part: Path, place: Path) -> None:
    """Move a finished file or folder of :meth:`Folder.part` to its place, where it replaces what is there."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if part.is_dir() and place.is_dir():
        old = part.with_name(f"{part.name}.old")
        os.replace(place, old)
        os.replace(part, place)
        shutil.rmtree(old, ignore_errors=True)
    else:
        os.replace(part, place)


def key(*content) -> str:
    """SHA-256 (hexadecimal) of anything that is JSON."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


_sealed = key
"""What tells a record that was written here from one that was damaged or changed since."""


def digest(path: str | os.PathLike | None) -> str | None:
    """SHA-256 (hexadecimal) of a file's content, None for None; raises OSError."""
    if path is None:
        return None
    facts = os.stat(path)
    return _digest(os.fspath(path), facts.st_size, facts.st_mtime_ns)


@lru_cache(maxsize=4096)
def _digest(path: str, _size: int, _written: int) -> str:
    return sha256(path)


def _read(path: Path) -> dict | None:
    try:
        content = json_text.read(path)
    except (OSError, ValueError):
        return None  # absent, or not ours: the stage is done again
    return content if isinstance(content, dict) else None


def _write(path: Path, content: dict) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(content, sort_keys=True, indent=1) + "\n", "utf-8")


def _size(path: Path) -> int:
    """Bytes of a file, number of files in a folder, -1 for nothing."""
    try:
        return sum(1 for _ in path.iterdir()) if path.is_dir() else path.stat().st_size
    except OSError:
        return -1


def _age(path: Path) -> float:
    try:
        return time.time() - path.stat().st_mtime
    except OSError:
        return 0.0
