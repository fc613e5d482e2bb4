"""Plans and checks the output files of a command before any work begins, and writes motions to them."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..files import check_output

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

    Raises :class:`UsageError` or :class:`OutputUnwritable`.
    """
    for path in outputs:
        if path.suffix.lower() not in suffixes:
            raise UsageError(f"{path} has no suffix that can be written here.", f"Use one of {', '.join(suffixes)}.")
    takes = request.takes if request else 1
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


def save(motion: "Motion", path: Path) -> None:
    """Write a motion in the format of the path's suffix."""
    from ...rigs import bvh
    from ..motion import json_export

    writers = {".npz": lambda motion, path: motion.save(path), ".bvh": bvh.save, ".json": json_export.save, ".tsv": _save_cues}
    writer = _save_cues if path.name.lower().endswith(".rhubarb.json") else writers[path.suffix.lower()]
    writer(motion, path)


def _save_cues(motion: "Motion", path: Path) -> None:
    """Write the mouth as cues in Rhubarb's format; raises :class:`UsageError` without a face."""
    from ..motion import rhubarb

    if motion.face is None:
        raise UsageError(f"{path} is to hold a mouth, and there is no face.", "Add --face.")
    rhubarb.save(motion.face, path)
