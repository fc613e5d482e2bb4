"""Training logs: JSON lines, and optionally a CSV table and TensorBoard."""

import csv
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...errors import UsageError

LOG, TABLE = "log.jsonl", "log.csv"
KINDS = ("csv", "tensorboard")


def parse_kinds(text: str) -> tuple[str, ...]:
    """Parse kinds of logs such as ``csv,tensorboard``; raises :class:`UsageError` if one is unknown or not installed."""
    result = tuple(filter(None, (part.strip() for part in text.split(","))))
    for kind in result:
        if kind not in KINDS:
            raise UsageError(f"There is no log {kind!r}.", f"Logs are {', '.join(KINDS)}.")
    if "tensorboard" in result and importlib.util.find_spec("tensorboard") is None:
        raise UsageError("TensorBoard is not installed.", 'Leave it out of --log, or: pip install "s2ag[tensorboard]".')
    return result


class Logbook:
    """Log files in ``folder``; a resumed run appends to them from ``step`` on.

    ``log.csv`` has one row per value (step, minutes, name, value), since lines differ in their names. TensorBoard's files
    are in the folder ``tensorboard``.
    """

    def __init__(self, folder: Path, wanted: Sequence[str] = (), step: int = 0):
        self.folder, self.table = folder, "csv" in wanted
        self._board: Any = None
        if "tensorboard" in wanted:
            from torch.utils.tensorboard import SummaryWriter

            self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=step)

    def add(self, step: int, minutes: float, values: dict) -> dict:
        """Write ``values`` and return the JSON line as a dictionary."""
        line = {"step": step, "minutes": round(minutes, 2), **values}
        with open(self.folder / LOG, "a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        if self.table:
            has_header = (self.folder / TABLE).exists()
            with open(self.folder / TABLE, "a", encoding="utf-8", newline="") as file:
                rows = csv.writer(file)
                rows.writerows([] if has_header else [("step", "minutes", "name", "value")])
                rows.writerows((step, line["minutes"], name, value) for name, value in values.items())
        if self._board is not None:
            for name, value in values.items():
                if isinstance(value, int | float):
                    self._board.add_scalar(name, value, step)
                else:
                    self._board.add_text(name, str(value), step)
        return line

    def close(self) -> None:
        """Flush and close TensorBoard's files."""
        if self._board is not None:
            self._board.close()
