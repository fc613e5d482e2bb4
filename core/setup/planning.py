"""How the engine's own Python environment is made, in a folder that the user named: what with, what of, and what is deleted.

A half-made environment is never used, and a new one takes over only when it works.
"""

import contextlib
import importlib.util
import json
import os
import shlex
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from .environment import SetupFailed, environments, number, python_in, requirements, size

PYTHONS = (3, 11), (3, 14)
"""First version of Python that the engine's packages are made for, first that they are not."""
SPARE = 0.7e9
"""Bytes that the making needs beside."""
CPU_INDEX = "https://download.pytorch.org/whl/cpu"
"""Where PyTorch's builds without CUDA are, which are a tenth in size and all that the engine uses."""
SMALL_TORCH = "torch==2.13.0+cpu"
"""What that index alone has: where it cannot be had, pip stops instead of fetching CUDA."""
STALE = 3600.0
"""Seconds after which a half-made environment that nobody works on is removed."""

_UNWANTED = ("PYTHONHOME", "PYTHONPATH", "PYTHONSAFEPATH", "PIP_USER", "PIP_TARGET", "PIP_PREFIX", "VIRTUAL_ENV")
_ABOUT = (
    "import importlib.util as u, json, sys; "
    "print(json.dumps([sys.version_info[:2], [n for n in ('venv', 'ensurepip') if not u.find_spec(n)]]))"
)


@dataclass(frozen=True)
class Plan:
    """How an environment is made: ``python`` makes ``environment``, pip fills it from the registry or from ``wheels``."""

    python: str
    environment: Path
    wheels: Path | None = None
    cpu_only: bool = True
    recognise: bool = False

    @property
    def make(self) -> list[str]:
        """The command that makes the empty environment."""
        return [self.python, "-I", "-m", "venv", str(self.environment)]

    @property
    def fill(self) -> list[str]:
        """The command that installs the packages."""
        command = [str(python_in(self.environment)), "-I", "-m", "pip", "install"]
        command += ["--disable-pip-version-check", "--no-input", "--no-cache-dir", "--only-binary", ":all:"]
        if self.wheels:
            command += ["--no-index", "--find-links", str(self.wheels)]
        small = self.cpu_only and not self.wheels and sys.platform == "linux"
        if small:
            command += ["--extra-index-url", CPU_INDEX]
        return command + wanted(self.recognise, small)

    @property
    def text(self) -> str:
        """Both commands as a terminal takes them."""
        quoted = subprocess.list2cmdline if os.name == "nt" else shlex.join
        return f"{quoted(self.make)}\n{quoted(self.fill)}"

    @property
    def source(self) -> str:
        """Where the packages come from, for people."""
        return str(self.wheels) if self.wheels else "the package registry"


def wanted(recognise: bool = False, small: bool = False) -> list[str]:
    """:func:`requirements`, with torch as ``$S2AG_TORCH`` wants it; else ``small`` is the build without CUDA or none."""
    torch = os.environ.get("S2AG_TORCH", "") or (SMALL_TORCH if small else "")
    return [torch if torch and line.startswith("torch") else line for line in requirements(recognise)]


def plan(folder: str | os.PathLike, python: str = "", wheels: str = "", cpu_only: bool = True, recognise: bool = False) -> Plan:
    """How the next environment in ``folder`` is made; raises :class:`SetupFailed` where it cannot be.

    ``python`` makes it (empty: this one or one on the search path), ``wheels`` is a folder of wheels to use instead of the
    registry, ``recognise`` adds the speech recogniser.
    """
    folder = Path(os.path.abspath(folder))
    following = 1 + max((number(path) for path in environments(folder)), default=0)
    place = Path(os.path.abspath(wheels)) if wheels else None
    if place and not (place.is_dir() and any(place.glob("*.whl"))):
        raise SetupFailed(f"{place} is no folder of wheels.", "Name a folder with .whl files.")
    _require_space(folder, size(bool(place) or cpu_only)[1] + SPARE)
    return Plan(find_python(python), folder / f"engine-{following}", place, cpu_only, recognise)


def find_python(named: str = "") -> str:
    """A Python that can make environments of the engine; raises :class:`SetupFailed`.

    ``named``, else this one, else python3.13 to python3.11 and python3 on the search path.
    """
    if named:
        found = shutil.which(named)
        if not found:
            raise SetupFailed(f"The Python {named} cannot be run.", "Name a Python from 3.11 to 3.13, or none.")
        if fault := _fault(found):
            raise SetupFailed(f"{found} {fault}.", "Name another Python from 3.11 to 3.13 that has venv, or none.")
        return found
    own = all(importlib.util.find_spec(name) for name in ("venv", "ensurepip"))
    if sys.executable and own and PYTHONS[0] <= sys.version_info[:2] < PYTHONS[1]:
        return sys.executable
    names = [f"python3.{minor}" for minor in range(PYTHONS[1][1] - 1, PYTHONS[0][1] - 1, -1)] + ["python3", "python"]
    for candidate in filter(None, map(shutil.which, names)):
        if not _fault(candidate):
            return candidate
    version = ".".join(map(str, sys.version_info[:2]))
    because = f"; this one is {version}." if own else ", and this one cannot make environments."
    message = f"No Python from 3.11 to 3.13 is here{because}"
    raise SetupFailed(message, "Install one (with venv), or name it with --python.")


def remove(folder: str | os.PathLike) -> None:
    """Delete every environment in ``folder``, half-made ones too; raises :class:`SetupFailed` if one stays."""
    for path in environments(Path(folder)):
        (path / "engine.json").unlink(missing_ok=True)  # from here on it is no engine, whatever else stays
        discard(path)
        if path.exists():
            raise SetupFailed(f"{path} cannot be deleted.", "Close what uses it, and delete the folder by hand.")


def discard(path: Path) -> None:
    """Delete a folder as far as the system lets us."""
    shutil.rmtree(path, ignore_errors=True)


def tidy(folder: Path, keep: Path) -> threading.Thread:
    """Delete other environments than ``keep``, in the thread that is returned; one that somebody else makes is left alone."""

    def work():
        for path in environments(folder):
            if path != keep and ((path / "engine.json").is_file() or time.time() - _worked_on(path) > STALE):
                discard(path)

    thread = threading.Thread(target=work, name="s2ag tidy")
    thread.start()
    return thread


def clean_environment(place: Path, wheels: Path | None) -> dict:
    """The variables with which an environment is made: nothing of the user's may leak into it."""
    variables = {name: value for name, value in os.environ.items() if name not in _UNWANTED}
    variables.update(TMPDIR=str(place), TEMP=str(place), TMP=str(place), PYTHONUNBUFFERED="1", PIP_PROGRESS_BAR="off")
    if wheels:  # the folder and nothing else, whatever pip's settings say
        variables = {name: value for name, value in variables.items() if not name.startswith("PIP_")}
        variables.update(PIP_CONFIG_FILE=os.devnull, PIP_PROGRESS_BAR="off")
    return variables


def _fault(python: str) -> str:
    """Why ``python`` cannot make the environment, or nothing."""
    variables = {name: value for name, value in os.environ.items() if name not in _UNWANTED}
    with contextlib.suppress(OSError, ValueError, subprocess.SubprocessError):
        done = subprocess.run([python, "-I", "-c", _ABOUT], capture_output=True, timeout=20, check=True, env=variables)
        version, missing = json.loads(done.stdout)
        if not PYTHONS[0] <= tuple(version) < PYTHONS[1]:
            return f"is version {'.'.join(map(str, version))}"
        return f"lacks {' and '.join(missing)}" if missing else ""
    return "does not run"


def _require_space(folder: Path, needed: float) -> None:
    there = next(path for path in (folder, *folder.parents) if path.exists())
    free = shutil.disk_usage(there).free
    if free < needed:
        message = f"Only {free / 1e9:.1f} GB are free in {there}; the engine needs {needed / 1e9:.1f} GB."
        raise SetupFailed(message, "Free some space.")


def _worked_on(path: Path) -> float:
    """When a half-made environment was last seen growing; the one who makes it touches ``building``."""
    times = [0.0]
    for place in (path, path / "building"):
        with contextlib.suppress(OSError):
            times.append(place.stat().st_mtime)
    return max(times)
