"""How much of each source of the made data a network performs: what it knows, told apart by where it could know it from."""

from pathlib import Path

import numpy as np

from ..bench import external_rows, rows
from ..bench.data import Data
from ..bench.evaluation import Bench
from ..bench.run import EXTRACTOR
from ..bench.setting import read
from ..metrics.extractor import Extractor
from . import gestures


def told(made: np.ndarray, real: np.ndarray, given: int) -> dict[str, float]:
    """Return for each source the share of its variance in ``real`` that ``made`` tells, both ``(n, T, 9, 3)``.

    Sources move arms along axes of their own. Frames after the ``given`` ones count. Noise of the source's size has -1.
    """
    wanted, found = (gestures.arms(part[:, given:]).reshape(-1, 12) for part in (real, made))
    result = {}
    for name, basis in gestures.axes().items():
        true, guess = wanted @ basis.T, found @ basis.T
        result[name] = float(1 - np.square(guess - true).sum() / np.square(true - true.mean(0)).sum())
    return result


def table(folder: Path, windows: int = 600) -> str:
    """Return the markdown table of a bench in ``folder``: a row for each system, means of its seeds."""
    held = read(folder)
    data = Data(held.data, folder, held.setting.filtered)
    bench = Bench(data, Extractor.load(folder / EXTRACTOR), windows)
    lines = ["| row | " + " | ".join(gestures.SHARES) + " |", "|---" * (len(gestures.SHARES) + 1) + "|"]
    for row in rows.read_rows(folder):
        found = []
        for seed in row.seeds:
            performer = external_rows.external_row(folder / f"{row.name}-{seed}", bench, "cpu")
            found.append(list(told(performer.perform(0, "own"), bench.real, data.given).values()))
        lines.append(f"| {row.title} | " + " | ".join(map(_cell, np.transpose(found))) + " |")
    return "\n".join(lines)


def _cell(values: np.ndarray) -> str:
    return f"{values.mean():.2f}" + (f" ({values.min():.2f} to {values.max():.2f})" if len(values) > 1 else "")
