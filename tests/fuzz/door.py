"""A door by which files of others come in: good files to damage, and what reads them as the product does."""

import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mutations

ROOT = Path(__file__).resolve().parents[2]
HELLO = ROOT / "examples" / "hello.flac"
Seeds = list[tuple[str, bytes]]


@dataclass(frozen=True)
class Door:
    """``make()`` gives good files by suffix, ``use(path)`` reads one or raises S2agError, ``damage`` suits its form."""

    name: str
    make: Callable[[], Seeds]
    use: Callable[[Path], object]
    damage: Callable = mutations.of_bytes

    def seeds(self) -> Seeds:
        """The good files, made once."""
        return _made(self)

    def valid(self, folder: Path) -> Path:
        """A good file in ``folder``."""
        suffix, data = self.seeds()[0]
        path = folder / f"good{suffix}"
        path.write_bytes(data)
        return path


@cache
def _made(door: Door) -> Seeds:
    return door.make()


def written(*writers) -> Seeds:
    """What functions of a path write, each with the suffix it is named with."""
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for number, (suffix, write) in enumerate(writers):
            path = Path(folder) / f"{number}{suffix}"
            write(path)
            found.append((suffix, path.read_bytes()))
    return found


def put(path: Path, place: Path) -> None:
    """Put an input where the product will read it: a copy of a file, what else there is (a pipe, a link) itself."""
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    if path.is_file():
        shutil.copy(path, place)
    elif os.path.lexists(path):
        path.rename(place)
