"""Logs of a training: lines, a table, and TensorBoard's files where that is installed."""

import csv
import importlib.util
import json

import pytest

pytest.importorskip("torch")

from s2ag.core.errors import UsageError  # noqa: E402
from s2ag.core.learning.train import logbook  # noqa: E402
from s2ag.core.learning.train.config import TrainConfig  # noqa: E402


def test_a_table_goes_on_where_it_was(tmp_path):
    book = logbook.Logbook(tmp_path, ("csv",))
    assert book.add(50, 0.123, {"huber": 1.5, "rate": 3}) == {"step": 50, "minutes": 0.12, "huber": 1.5, "rate": 3}
    book.close()
    book = logbook.Logbook(tmp_path, ("csv",), 50)
    book.add(100, 0.5, {"warning": "odd, but true"})
    book.close()
    with open(tmp_path / logbook.TABLE, newline="") as file:
        rows = list(csv.reader(file))
    assert rows == [
        ["step", "minutes", "name", "value"],
        ["50", "0.12", "huber", "1.5"],
        ["50", "0.12", "rate", "3"],
        ["100", "0.5", "warning", "odd, but true"],
    ]
    lines = [json.loads(line) for line in (tmp_path / logbook.LOG).read_text().splitlines()]
    assert [line["step"] for line in lines] == [50, 100] and lines[0]["huber"] == 1.5


def test_wanted_logs_are_known():
    assert logbook.parse_kinds(" csv,") == ("csv",) and logbook.parse_kinds("") == ()
    with pytest.raises(UsageError, match="no log 'wandb'"):
        TrainConfig(log="wandb")


def test_tensorboard_holds_the_figures_or_says_what_is_missing(tmp_path):
    if importlib.util.find_spec("tensorboard") is None:
        with pytest.raises(UsageError, match="not installed"):
            TrainConfig(log="csv,tensorboard")
        return
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    book = logbook.Logbook(tmp_path, ("tensorboard",))
    book.add(50, 0.1, {"huber": 1.5, "warning": "odd"})
    book.close()
    events = EventAccumulator(str(tmp_path / "tensorboard")).Reload()
    assert [(one.step, one.value) for one in events.Scalars("huber")] == [(50, 1.5)]
