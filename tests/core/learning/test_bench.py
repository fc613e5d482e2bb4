"""The bench end to end on a toy data set: stopped, continued, repeated, refused, and the table it writes."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from rounding import same_figures  # noqa: E402
from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.bench import table  # noqa: E402
from s2ag.core.learning.bench.evaluation import FIGURES, Bench  # noqa: E402
from s2ag.core.learning.bench.references import reference_rows  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS, Setting  # noqa: E402
from s2ag.core.learning.bench.training import Training  # noqa: E402
from s2ag.core.learning.metrics.extractor import Extractor  # noqa: E402
from s2ag.core.learning.systems.catalogue import SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.train.storage import save_arrays  # noqa: E402
from toy_bench import bench_arrays  # noqa: E402

TINY = SETTINGS["tiny"]


def trained(data, folder, name, **changes):
    torch.manual_seed(1)
    system = SYSTEMS[name].build(BuildOptions(data.vectors, data.speakers, 0.05, False, 0.25))
    return Training(system, data, TINY.replace(**changes), 1, folder)


@pytest.mark.parametrize("name", ["s2ag", "seq2seq"])
def test_a_stopped_training_repeats_an_uninterrupted_one(data, tmp_path, name):
    whole = trained(data, tmp_path / "whole", name, steps=4)
    assert whole.run()
    count = iter([False, False, True])
    assert not trained(data, tmp_path / "parts", name, steps=4).run(lambda: next(count))
    rest = trained(data, tmp_path / "parts", name, steps=4)
    assert rest.done == 2 and rest.run()
    for one, two in zip(whole.system.parameters(), rest.system.parameters(), strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)


def test_a_training_goes_on_in_a_longer_setting(data, tmp_path):
    """Systems without schedules in shares of the training: nothing else in a step knows how many there will be."""
    whole = trained(data, tmp_path / "whole", "s2ag", steps=4)
    assert whole.run() and trained(data, tmp_path / "parts", "s2ag", steps=2).run()
    rest = trained(data, tmp_path / "parts", "s2ag", steps=4)
    assert rest.done == 2 and rest.run()
    for one, two in zip(whole.system.parameters(), rest.system.parameters(), strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)


def test_the_weights_with_the_best_validation_count(data, tmp_path):
    training, kept = trained(data, tmp_path, "s2ag", steps=6, validate_every=2), {}
    scores = iter([5.0, 3.0, 4.0])

    def validate():
        kept[training.done] = [p.detach().clone() for p in training.system.parameters()]
        return {"maje_code": next(scores), "fgd": -float(training.done)}

    stops = iter([False] * 5 + [True])
    assert not training.run(lambda: next(stops), validate)
    training = trained(data, tmp_path, "s2ag", steps=6, validate_every=2)
    assert training.run(validate=validate) and training.best == 4
    assert [point["step"] for point in training.curve] == [2, 4, 6]
    for one, two in zip(training.system.parameters(), kept[4], strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)
    again = trained(data, tmp_path, "s2ag", steps=6, validate_every=2, select="fgd")
    assert again.done == 6 and again.best == 6


def test_a_training_ends_where_its_curve_is_flat(data, tmp_path):
    scores = iter([5.0, 3.0, 4.0, 2.0, 2.0, 2.5, 1.0])
    training = trained(data, tmp_path, "s2ag", steps=50, validate_every=1, patience=2)
    assert training.run(validate=lambda: {"maje_code": next(scores), "fgd": 1.0})
    assert training.done == 6 and training.best == 4 and next(scores) == 1.0
    again = trained(data, tmp_path, "s2ag", steps=50, validate_every=1, patience=2)
    assert again.over and again.run() and again.done == 6
    assert not trained(data, tmp_path, "s2ag", steps=50, validate_every=1, patience=3).over


def test_validation_leaves_the_training_alone(data, tmp_path):
    alone, judged = trained(data, tmp_path / "a", "gtc"), trained(data, tmp_path / "b", "gtc", validate_every=1)
    bench = Bench(data, Extractor().eval(), 20, split=1)
    assert alone.run() and judged.run(validate=lambda: bench.score(bench.perform(judged.system, 1)))
    last = trained(data, tmp_path / "b", "gtc", validate_every=0)
    for one, two in zip(alone.system.parameters(), last.system.parameters(), strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)


def test_an_update_without_a_finite_gradient_is_left_out(data, tmp_path):
    training = trained(data, tmp_path, "s2ag", steps=4)
    sample = data.sample(training._windows(0))
    weight = next(training.system.performer.parameters())
    hook = weight.register_hook(lambda grad: torch.full_like(grad, torch.nan))
    before = [p.detach().clone() for p in training.system.performer.parameters()]
    training.step(sample)
    assert training.skipped == 1 and training.done == 1
    assert all(torch.equal(a, b) for a, b in zip(before, training.system.performer.parameters(), strict=True))
    hook.remove()
    training.step(sample)
    assert training.skipped == 1 and not torch.equal(before[0], weight)
    with torch.no_grad():
        weight.fill_(torch.nan)
    with pytest.raises(UsageError, match="diverged after 2 batches"):
        training.step(sample)


@pytest.mark.parametrize("name", SYSTEMS)
def test_low_precision_trains_much_the_same(data, tmp_path, name):
    whole, low = (trained(data, tmp_path / precision, name, precision=precision) for precision in ("32-true", "bf16-mixed"))
    sample = data.sample(whole._windows(0))
    exact, rounded = whole.step(sample), low.step(sample)
    for key, value in exact.items():
        assert float(rounded[key]) == pytest.approx(float(value), rel=0.05, abs=0.01), key
    same = all(torch.equal(a, b) for a, b in zip(whole.system.parameters(), low.system.parameters(), strict=True))
    assert same == (not whole.system.mixed)
    assert all(p.dtype == torch.float32 and p.isfinite().all() for p in low.system.parameters())


def test_every_window_is_seen_once_a_pass(data, tmp_path):
    training = trained(data, tmp_path, "seq2seq")
    steps = len(data.windows[0]) // TINY.batch
    seen = np.concatenate([training._windows(step) for step in range(steps)])
    assert len(np.unique(seen, axis=0)) == len(seen) == steps * TINY.batch
    assert not np.array_equal(training._windows(0), training._windows(steps))


@pytest.mark.slow
def test_performed_motion_is_its_own_best_score(data):
    torch.manual_seed(0)
    bench = Bench(data, Extractor().eval(), 40)
    rows = reference_rows(bench)
    real, held = (rows[name]["figures"] for name in ("real", "held"))
    for name in ("maje_code", "mad_code", "fgd", "mpjpe", "feature_distance", "hellinger"):
        assert real[name][0] == pytest.approx(0, abs=1e-4) and held[name][0] > real[name][0]
    assert real["cca"][0] == pytest.approx(1) and held["jerk"][0] < real["jerk"][0]
    assert set(real) == set(FIGURES) - {"multimodality"}


@pytest.mark.slow
def test_all_eight_from_the_command_line(corpus, tmp_path, capsys):
    command = ["bench", "--data", str(corpus), "--out", str(tmp_path / "b"), "--setting", "tiny", "--threads", "1"]
    command += ["--systems", ",".join(SYSTEMS)]
    assert main(command) == 0
    out = capsys.readouterr().out
    report = json.loads((tmp_path / "b" / "table.json").read_text())
    assert list(report["systems"]) == list(SYSTEMS)
    for name, row in report["systems"].items():
        assert SYSTEMS[name].title in out and row["steps"] == 3
        assert set(row["figures"]) == set(FIGURES) and all(np.isfinite(row["figures"][key]).all() for key in table.PAPER)
    assert out == (tmp_path / "b" / "table.md").read_text() and "24.49" in out and "82.41*" in out and "collapsed" in out
    assert (
        report["systems"]["s2ag"]["figures"]["multimodality"][0] > 0 == report["systems"]["s2g"]["figures"]["multimodality"][0]
    )
    before = json.loads((tmp_path / "b" / "s2ag-1" / "figures.json").read_text())
    assert main(command) == 0
    assert json.loads((tmp_path / "b" / "s2ag-1" / "figures.json").read_text()) == before
    assert main([*command, "--steps", "9"]) == 2 and "other settings" in capsys.readouterr().err


@pytest.mark.slow
def test_the_same_seed_gives_the_same_figures(corpus, tmp_path):
    figures = []
    for place in "ab":
        report = Runner(tmp_path / place, corpus, TINY, say=lambda text: None).go(["s2ag"], "")
        figures.append({"s2ag": report["systems"]["s2ag"]["figures"]})
    same_figures(*figures)


@pytest.mark.slow
def test_side_by_side_gives_the_same_figures(corpus, tmp_path, capsys):
    common = ["bench", "--data", str(corpus), "--setting", "tiny", "--threads", "1", "--systems", "seq2seq,jem,s2ag"]
    assert main([*common, "--out", str(tmp_path / "a")]) == 0
    assert main([*common, "--out", str(tmp_path / "b"), "--jobs", "2"]) == 0
    tables = (json.loads((tmp_path / place / "table.json").read_text())["systems"] for place in "ab")
    same_figures(*({name: row["figures"] for name, row in systems.items()} for systems in tables))
    assert "1 CPU threads each, 2 side by side" in capsys.readouterr().out
    assert (tmp_path / "b" / "curves.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
def test_a_table_may_count_trainings_that_are_not_over(corpus, tmp_path, capsys):
    stops = iter([False, False, True])
    runner = Runner(tmp_path, corpus, TINY.replace(draws=1), say=print)
    assert runner.go(["gtc"], "", lambda: next(stops)) is None
    assert main(["bench", "--out", str(tmp_path)]) == 2 and "is at 2 of 3 steps" in capsys.readouterr().err
    assert main(["bench", "--out", str(tmp_path), "--unfinished"]) == 0
    row = json.loads((tmp_path / "table.json").read_text())["systems"]["gtc"]
    assert row["steps"] == 2 and row["best"] == [2] and "| GTC |" in capsys.readouterr().out
    assert runner.go(["gtc"], "")["systems"]["gtc"]["steps"] == 3


@pytest.mark.slow
def test_trainings_side_by_side_stop_and_go_on(corpus, tmp_path):
    runner = Runner(tmp_path, corpus, TINY, say=print)
    assert runner.go(["seq2seq", "gtc"], "", lambda: True, jobs=2) is None and not (tmp_path / "table.md").exists()
    assert list(runner.go(["seq2seq", "gtc"], "", jobs=2)["systems"]) == ["seq2seq", "gtc"]


@pytest.mark.slow
def test_what_one_of_several_trainings_refuses_is_told(corpus, tmp_path):
    runner = Runner(tmp_path, corpus, TINY, say=print)
    (tmp_path / "seq2seq-1").mkdir()
    (tmp_path / "seq2seq-1" / "state.safetensors").write_bytes(b"damaged")
    with pytest.raises(CheckpointUnreadable, match="cannot be continued"):
        runner.go(["seq2seq", "gtc"], "", jobs=2)


def test_data_without_validation_windows_is_refused(tmp_path):
    arrays, meta = bench_arrays()
    arrays["split"] = np.where(arrays["split"] == 1, 0, arrays["split"]).astype(arrays["split"].dtype)
    data = save_arrays(tmp_path / "c", arrays, meta)
    with pytest.raises(UsageError, match="no validation windows"):
        Runner(tmp_path / "b", data, TINY, say=print).go(["gtc"], "")


def test_stopping_writes_no_table(corpus, tmp_path):
    runner = Runner(tmp_path, corpus, TINY, say=lambda text: None)
    assert runner.go(["gtc"], "", lambda: True) is None and not (tmp_path / "table.md").exists()


def test_wrong_options_are_one_sentence(corpus, tmp_path, capsys):
    common = ["bench", "--data", str(corpus), "--out", str(tmp_path / "x")]
    for wrong, sentence in (
        (["--setting", "huge"], "no setting"),
        (["--systems", "s2ag,magic"], "no system"),
        (["--seeds", "a"], "no seeds"),
        (["--draws", "0"], "draws is 0"),
        (["--jobs", "0"], "jobs is 0"),
        (["--precision", "16"], "no precision"),
    ):
        assert main([*common, *wrong]) == 2
        assert sentence in capsys.readouterr().err
    with pytest.raises(UsageError, match="share"):
        Setting("odd", share=0)
    assert Setting.from_dict(TINY.to_dict()) == TINY


def test_the_verdict_says_by_how_much():
    figures = {"maje_code": [10.0, 0], "mad_code": [2.0, 0], "fgd": [4.0, 0]}
    worse = {"maje_code": [20.0, 0], "mad_code": [1.0, 0], "fgd": [5.0, 0]}
    report = {"systems": {"s2ag": {"figures": figures}, "gtc": {"figures": worse}}, "extractor": {"trusted": True}}
    found = table.better(report)
    assert set(found) == set(table.PAPER)
    assert found["maje_code"]["gtc"] == pytest.approx(0.5) and found["mad_code"]["gtc"] == pytest.approx(-1.0)
    assert table.summarise([{"a": 1.0}, {"a": 3.0}])["a"] == pytest.approx([2.0, 2**0.5])


def _report(trusted: bool = True) -> dict:
    """Of two systems, as the bench writes it."""
    row = {"steps": 3, "best": [3], "minutes": 0.1, "windows_per_second": 2.0, "random_ids": None, "ids": "own", "made": ""}
    row |= {"seeds": [1], "intervals": {"own": dict.fromkeys(FIGURES)}, "against": {}}
    names = enumerate(("s2ag", "gtc"), 1)
    rows = {name: {**row, "title": name, "figures": dict.fromkeys(FIGURES, [size, 0.0])} for size, name in names}
    found = {"missed": 0.9, "halves": 0.1, "still": 0.1, "ratio": 1.0, "trusted": trusted}
    counts = {"training": 1, "test": 1, "talks": 1}
    facts = {"command": "", "device": "", "minutes": 0.2, "windows": counts, "setting": TINY.to_dict(), "fps": 15.0}
    return {**facts, "systems": rows, "references": {}, "extractor": found}


@pytest.mark.parametrize("trusted", [True, False])
def test_what_collapsed_features_say_is_neither_shown_nor_ranked(trusted):
    text = table.markdown(_report(trusted))
    verdict = text.partition("## S2AG against the others")[2]
    assert ("FGD" in verdict) == trusted and "MAJE" in verdict
    assert text.count("| collapsed") == (0 if trusted else 2 * len(table.OF_FEATURES))


@pytest.mark.parametrize("source", ["directed", "ted", "genea", ""])
def test_a_table_speaks_of_its_own_data_set_alone(data, source, monkeypatch):
    note = table.markdown({**_report(), "source": source}).partition("- MAJE (code) and")[0]
    assert ("directed" in note) == (source == "directed") and ("another one" in note) == (source != "ted")
    monkeypatch.delitem(data.corpus.meta, "source", raising=False)
    monkeypatch.setitem(data.corpus.meta, *(("statistics", {}) if source == "directed" else ("source", source)))
    assert data.source == source


def test_a_missing_folder_leaves_nothing_and_is_one_sentence(tmp_path, capsys):
    out = tmp_path / "bench"
    assert main(["bench", "--data", str(tmp_path / "none"), "--out", str(out), "--setting", "tiny"]) == 2
    told = capsys.readouterr().err
    assert "there is no such folder" in told and "Errno" not in told and not out.exists()


def test_weights_of_a_bench_are_named_as_such(data, tmp_path, capsys):
    trained(data, tmp_path / "s2ag-1", "s2ag", steps=1).run()
    assert main(["styles", "--checkpoint", str(tmp_path / "s2ag-1" / "state.safetensors")]) == 2
    assert "system of s2ag bench" in capsys.readouterr().err
