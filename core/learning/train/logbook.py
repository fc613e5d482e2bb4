"""Figures of a run: one JSON object a line, and where wanted a table or what TensorBoard shows."""

import csv
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path

from ...errors import UsageError

LOG, TABLE = "log.jsonl", "log.csv"
KINDS = ("csv", "tensorboard")


def kinds(text: str) -> tuple[str, ...]:
    """The kinds in a text such as ``csv,tensorboard``; raises :class:`UsageError` for one that is unknown or not installed."""
    found = tuple(filter(None, (part.strip() for part in text.split(","))))
    for kind in found:
        if kind not in KINDS:
            raise UsageError(f"There is no log {kind!r}.", f"Logs are {', '.join(KINDS)}.")
    if "tensorboard" in found and importlib.util.find_spec("tensorboard") is None:
        raise UsageError("TensorBoard is not installed.", 'Leave it out of --log, or: pip install "s2ag[tensorboard]".')
    return found


class Logbook:
    """Log files in ``folder``; a continued run appends to them. ``step`` is where it begins.

    ``log.csv`` has a row for every figure (step, minutes, name, value), since lines do not have the same figures. TensorBoard's
    files lie in the folder ``tensorboard``.
    """

    def __init__(self, folder: Path, wanted: Sequence[str] = (), step: int = 0):
        self.folder, self.table, self._board = folder, "csv" in wanted, None
        if "tensorboard" in wanted:
            from torch.utils.tensorboard import SummaryWriter

            self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=step)

    def add(self, step: int, minutes: float, values: dict) -> dict:
        """Write ``values`` and return the line that was written."""
        line = {"step": step, "minutes": round(minutes, 2), **values}
        with open(self.folder / LOG, "a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        if self.table:
            begun = (self.folder / TABLE).exists()
            with open(self.folder / TABLE, "a", encoding="utf-8", newline="") as file:
                rows = csv.writer(file)
                rows.writerows([] if begun else [("step", "minutes", "name", "value")])
                rows.writerows((step, line["minutes"], name, value) for name, value in values.items())
        for name, value in values.items() if self._board is not None else ():
            if isinstance(value, int | float):
                self._board.add_scalar(name, value, step)
            else:
                self._board.add_text(name, str(value), step)
        return line

    def close(self) -> None:
        """Write what TensorBoard's files lack."""
        if self._board is not None:
            self._board.close()
