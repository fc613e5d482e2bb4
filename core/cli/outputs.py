"""Plans and checks the output files of a command before any work begins, and writes motions to them."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..files import check_output
from .package_parts import require_whole

if TYPE_CHECKING:
    from ..motion.motion import Motion
    from ..synthesis.request import Request


def add_option(parser: argparse.ArgumentParser, suffixes: Sequence[str]) -> None:
    """Add the option ``-o``, which may be given several times."""
    kinds = ", ".join(suffixes)
    parser.add_argument(
        "-o",
        "--output",
        dest="outputs",
        metavar="OUT",
        type=Path,
        action="append",
        required=True,
        help=f"file to write ({kinds}); give it several times for several files; with --takes K, OUT-1 to OUT-K",
    )


def plan_files(
    outputs: Sequence[Path], suffixes: Sequence[str], request: "Request | None", inputs: Sequence[Path] = ()
) -> list[list[Path]]:
    """Return the files of each take of a request, or of one motion without a request; check suffixes, folders, duplicates, and
    that no input is overwritten.

    Raises :class:`UsageError` or :class:`OutputUnwritable`."""
    for path in outputs:
        if path.suffix.lower() not in suffixes:
            raise UsageError(f"{path} has no suffix that can be written here.", f"Use one of {', '.join(suffixes)}.")
    takes = len(request.identities) if request else 1
    files = [[numbered(path, take, takes) for path in outputs] for take in range(takes)]
    taken = {Path(path).resolve(): "is also an input" for path in inputs}
    for path in (path for take in files for path in take):
        place = check_output(path).resolve()
        if place in taken:
            raise UsageError(f"The output {path} {taken[place]}.", "Give every output its own name.")
        taken[place] = "is named twice"
    return files


def numbered(path: Path, take: int, takes: int) -> Path:
    """Return ``OUT.npz`` for a single take, else ``OUT-1.npz``, ``OUT-2.npz`` ..."""
    return path if takes == 1 else path.with_name(f"{path.stem}-{take + 1}{path.suffix}")


def require_formats(outputs: Sequence[Path]) -> None:
    """Raise :class:`UsageError` in Blender's extension for motions in other formats than .npz."""
    for path in outputs:
        if path.suffix.lower() != ".npz":
            require_whole(f"{path.name}, a motion without a character, is an output")


def save(motion: "Motion", path: Path) -> None:
    """Write a motion in the format of the path's suffix."""
    if path.suffix.lower() == ".npz":
        motion.save(path)
        return
    from . import motion_export

    motion_export.save(motion, path)
