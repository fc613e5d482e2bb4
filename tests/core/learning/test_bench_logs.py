"""Logs of the bench's trainings: those of every training, by the same code."""

import csv
import json

import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS  # noqa: E402
from s2ag.core.learning.bench.training import Training  # noqa: E402
from s2ag.core.learning.systems.catalogue import SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.train.logbook import LOG, TABLE  # noqa: E402


def training(data, folder, logs=("csv",)):
    torch.manual_seed(1)
    system = SYSTEMS["seq2seq"].build(BuildOptions(data.vectors, data.speakers, 0.05, False))
    return Training(system, data, SETTINGS["tiny"].replace(steps=60, epochs=99, validate_every=30), 1, folder, logs=logs)


def test_means_of_losses_and_validations_are_logged_also_after_a_stop(data, tmp_path):
    one, losses = training(data, tmp_path), []
    step, one.step = one.step, lambda sample: losses.append(step(sample)) or losses[-1]
    stops = iter([False] * 40 + [True])
    assert not one.run(lambda: next(stops), lambda: {"maje_code": 5.0, "fgd": 1.0})
    two = training(data, tmp_path)
    step_two, two.step = two.step, lambda sample: losses.append(step_two(sample)) or losses[-1]
    assert two.run(validate=lambda: {"maje_code": 4.0, "fgd": 2.0})
    lines = [json.loads(line) for line in (tmp_path / LOG).read_text().splitlines()]
    assert [(line["step"], line.get("validation_maje_code")) for line in lines] == [(30, 5.0), (50, None), (60, 4.0)]
    logged = lines[1]
    assert set(logged) == {"step", "minutes", "windows_per_second", "squares", "continuity", "variance"}
    wanted = sum(float(one["squares"]) for one in losses[40:50]) / 10  # the ten steps of this run, not of fifty
    assert logged["squares"] == pytest.approx(wanted, abs=1e-4)
    with open(tmp_path / TABLE, newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["step", "minutes", "name", "value"] and [rows[-2][0], rows[-2][3]] == ["60", "4.0"]


def test_without_a_wish_there_are_lines_alone(data, tmp_path):
    one = training(data, tmp_path, ())
    stops = iter([False] * 30 + [True])
    one.run(lambda: next(stops), lambda: {"maje_code": 5.0, "fgd": 1.0})
    assert (tmp_path / LOG).is_file() and not (tmp_path / TABLE).exists()


def test_an_unknown_log_is_refused_before_anything_is_written(corpus, tmp_path, capsys):
    out = tmp_path / "bench"
    assert main(["bench", "--data", str(corpus), "--out", str(out), "--setting", "tiny", "--log", "wandb"]) == 2
    assert "no log 'wandb'" in capsys.readouterr().err and not out.exists()


@pytest.mark.slow
def test_the_command_logs_every_training_also_side_by_side(corpus, tmp_path):
    command = ["bench", "--data", str(corpus), "--out", str(tmp_path / "b"), "--setting", "tiny", "--threads", "1"]
    assert main([*command, "--systems", "seq2seq,jem", "--jobs", "2", "--log", "csv"]) == 0
    for name in ("seq2seq-1", "jem-1"):
        assert "validation_fgd" in (tmp_path / "b" / name / TABLE).read_text()
