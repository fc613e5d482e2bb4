"""Sheets of takes to choose from: many styles and seeds of one recording, drawn in one batch."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .. import json_text, styles
from ..declaration import KINDS
from ..errors import S2agError, UsageError
from ..files import atomic_file
from ..model.checkpoint_metadata import describe
from ..motion.motion import Motion
from ..settings import Settings, names_with, table

FORMAT = 1
MAX_CELLS = 10_000
"""Cells of a sheet."""
SHARED = {name: table(Settings)[name] for name in names_with(cell="sheet")}
"""Settings that are the same in all cells of a sheet."""
_REMEDY = "Make one with: s2ag sample AUDIO -o SHEET.mp4"


class SampleUnreadable(S2agError):
    """A sample sheet cannot be read, or lacks the requested cell."""


@dataclass(frozen=True)
class Cell:
    """One take on a sheet: where it stands (from 0), its ``style`` expression, its ``seed`` and which ``take`` of that seed
    it is (from 0), the points of the latent space ``(steps, size)`` that perform, and ``chance`` (0 in old sheets).
    """

    row: int
    column: int
    style: str
    seed: int
    take: int
    latent: list[list[float]]
    chance: int = 0

    @property
    def identity(self) -> dict[str, Any]:
        """Style, seed and number of the take."""
        return {"style": self.style, "seed": self.seed, "take": self.take}

    @property
    def label(self) -> tuple[str, str]:
        """What is printed under it: style, and seed with take, as in ``--seed 3 --takes 5``."""
        return self.style, f"seed {self.seed}  take {self.take + 1}"


@dataclass(frozen=True)
class Sheet:
    """A sample's recording (an absolute path), hash of its checkpoint and cells, and the ``settings`` that all its cells share
    (:data:`SHARED`), which have their defaults where they are not mentioned.
    """

    audio: str
    checkpoint: str
    cells: list[Cell]
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def columns(self) -> int:
        """Cells in a row."""
        return 1 + max(cell.column for cell in self.cells)

    @property
    def defaulted(self) -> dict[str, Any]:
        """All settings that the cells share."""
        return {name: self.settings.get(name, one.default) for name, one in SHARED.items()}

    def save(self, path: str | PathLike, **more: Any) -> None:
        """Write the sheet as JSON, whole or not at all; cells are numbered from 1."""
        cells = [{"cell": number, **asdict(one)} for number, one in enumerate(self.cells, 1)]
        about = {"audio": self.audio, "checkpoint": self.checkpoint, "cells": cells}
        content = {"format": FORMAT, **about, **self.defaulted, **more}
        with atomic_file(path) as temporary:
            temporary.write_text(json.dumps(content, indent=1) + "\n", "utf-8")

    @classmethod
    def load(cls, path: str | PathLike) -> "Sheet":
        """Read what :meth:`save` wrote; raises :class:`SampleUnreadable`."""
        try:
            content = json_text.read(path)
            if content["format"] != FORMAT:
                raise ValueError("another format")
            names = Cell.__dataclass_fields__
            cells = [Cell(**{name: {"chance": 0, **one}[name] for name in names}) for one in content["cells"]]
            settings = {name: content[name] for name in SHARED if name in content}
            sheet = cls(content["audio"], content["checkpoint"], cells, settings)
            sheet.check()
            return sheet
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise SampleUnreadable(f"{path} is not a sample.", _REMEDY) from error

    def check(self) -> None:
        """Raise ValueError or TypeError for what no sample holds."""
        texts = (self.audio, self.checkpoint, *(one.style for one in self.cells))
        wholes = [number for one in self.cells for number in (one.row, one.column, one.seed, one.take, one.chance)]
        kinds = [(value, str) for value in texts] + [(value, int) for value in wholes]
        kinds += [(value, KINDS[SHARED[name].kind]) for name, value in self.settings.items() if value is not None]
        if not all(type(value) in (kind if isinstance(kind, tuple) else (kind,)) for value, kind in kinds):
            raise TypeError("a value of another kind")
        if not self.cells or len(self.cells) > MAX_CELLS or min(wholes) < 0:
            raise ValueError("no cells, or too many")
        for one in self.cells:
            points = np.array(one.latent, float)
            if points.ndim != 2 or not points.size or not np.isfinite(points).all():
                raise ValueError("a latent that is no list of points")


def sample(
    session: Any,
    request: Any,
    every_style: Sequence[str],
    progress: Callable[[str, float], None] = lambda stage, value: None,
) -> tuple["Sheet", list[Motion], Any]:
    """Draw the takes of a request in each style in one batch: return the :class:`Sheet`, its motions, one a cell, and the
    first result.

    ``request`` gives everything but the style. With one style the cells make a square, else a row for each style.
    Raises what :meth:`Session.synthesize_all` raises.
    """
    results, takes = session.synthesize_all(request.in_styles(every_style), progress), len(request.identities)
    speakers = session.checkpoint.speakers
    columns = takes if len(every_style) > 1 else int(np.ceil(np.sqrt(takes)))
    cells, motions = [], []
    for style, result in zip(every_style, results, strict=True):
        for take, (motion, latent) in enumerate(zip(result.motions, result.latents, strict=True)):
            row, column = divmod(len(cells), columns)
            points, chance = [[float(value) for value in point] for point in latent], motion.meta.get("chance", 0)
            cells.append(Cell(row, column, style or styles.default_speaker(speakers), request.seed, take, points, chance))
            motions.append(motion)
    settings = {name: getattr(request, name) for name in SHARED}
    paths = {name: str(Path(settings[name]).absolute()) for name in names_with(cell="sheet", kind="path") if settings[name]}
    return Sheet(str(Path(request.audio).absolute()), session.checkpoint.hash, cells, settings | paths), motions, results[0]


def find_cell(reference: str) -> tuple[Sheet, Cell]:
    """Return the sheet and cell that ``SHEET.json:NUMBER`` names; raises :class:`SampleUnreadable`."""
    path, _, number = reference.rpartition(":")
    sheet = Sheet.load(path or reference)
    if not (path and number.isdecimal() and 1 <= int(number) <= len(sheet.cells)):
        message = f"{path} has no cell {number}." if path else f"{reference} names no cell."
        raise SampleUnreadable(message, f"Name one from 1 to {len(sheet.cells)}.")
    return sheet, sheet.cells[int(number) - 1]


def request_of_cell(reference: str, checkpoint: str | PathLike | None = None, audio: str = "") -> dict:
    """Return the fields of a :class:`Request` that makes the cell ``SHEET.json:NUMBER`` again, recording and words included;
    without its chance for another recording ``audio``.

    Raises :class:`SampleUnreadable`, and :class:`UsageError` where it was sampled with another ``checkpoint``.
    """
    sheet, one = find_cell(reference)
    if describe(checkpoint)["hash"] not in ("", sheet.checkpoint):
        raise UsageError(f"{reference} was sampled with another checkpoint.", "Name that one with --checkpoint.")
    chance = {"chance": one.chance} if audio in ("", sheet.audio) else {}
    return {"audio": sheet.audio, **sheet.defaulted, **one.identity, "latent": one.latent, **chance}
