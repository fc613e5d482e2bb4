"""Environments that were made: where one is, what is known of it, and the Python that a choice of the user's means.

The folder that the set-up was given holds ``engine-N``, environments of which the newest that was finished (its
``engine.json`` says so) is the engine, and ``logs``.
"""

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from .. import json_text
from ..errors import S2agError

SIZES = {True: (0.4e9, 1.3e9), False: (3e9, 8e9)}
"""Bytes that are fetched and that lie on the disk in the end: with PyTorch's small build (measured), and with CUDA (about)."""
ROOT = Path(__file__).parents[2]
_LARGEST = 1_000_000
"""Bytes of an environment's facts."""


class SetupFailed(S2agError):
    """There is no engine, or none could be made; ``log`` is the file that has all that was said."""

    log: Path | None = None


@dataclass(frozen=True)
class Environment:
    """A finished environment: its folder, and the facts that were found when it was made."""

    folder: Path
    facts: dict

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return python_in(self.folder)

    @property
    def broken(self) -> bool:
        """Whether its interpreter is gone, as when the Python that it was made with was removed."""
        return not self.python.exists()

    @property
    def outdated(self) -> bool:
        """Whether this version of s2ag needs other packages than those that were installed."""
        return self.facts.get("requirements") != requirements(self.recognises)

    @property
    def recognises(self) -> bool:
        """Whether it was made with the speech recogniser."""
        return bool(self.facts.get("recognise"))


def requirements(recognise: bool = False) -> list[str]:
    """What the engine needs, as pyproject.toml says it, other languages included; with ``recognise`` the recogniser, too."""
    import tomllib  # not at the start of every Blender

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    full = [line for line in extras["full"] if not line.startswith("s2ag[")] + extras["engine"]
    return project["dependencies"] + full + extras["languages"] + (extras["recognise"] if recognise else [])


def size(small: bool = True) -> tuple[float, float]:
    """Bytes that are fetched and that are taken in the end; ``small`` is PyTorch without CUDA, as it is but on Linux anyway."""
    return SIZES[small or sys.platform != "linux"]


def python_in(environment: Path) -> Path:
    """The interpreter of an environment."""
    return environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def environment(folder: str | os.PathLike) -> Environment | None:
    """The engine's environment in ``folder``: the newest that was finished, or ``folder`` itself if it is one; else None."""
    folder = Path(folder)
    for path in [folder, *sorted(environments(folder), key=number, reverse=True)]:
        try:
            facts = json_text.read(path / "engine.json", _LARGEST)
        except (OSError, ValueError):
            continue
        if isinstance(facts, dict):
            return Environment(path, facts)
    return None


def chosen(path: str | os.PathLike) -> str:
    """The Python that ``path`` means: a program itself, an environment's, or that of the folder that the set-up was given.

    Raises :class:`SetupFailed` for a folder without one.
    """
    path = Path(path)
    if not path.is_dir():
        return str(path)
    made = environment(path)
    python = made.python if made else python_in(path)
    if not python.exists():
        raise SetupFailed(f"No engine is in {path}.", "Choose the folder that the set-up command was given, or a Python.")
    return str(python)


def environments(folder: Path) -> list[Path]:
    """All environments in ``folder``, half-made ones too."""
    return [path for path in folder.glob("engine-*") if path.name[7:].isdecimal()] if folder.is_dir() else []


def number(path: Path) -> int:
    """The N of ``engine-N``."""
    return int(path.name[7:])
