"""Rows of the bench's table: seeds of their own, how sure they are, and what they answer."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.bench import references, rows, significance  # noqa: E402
from s2ag.core.learning.bench.evaluation import BY_WINDOW, Bench  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS, Setting  # noqa: E402
from s2ag.core.learning.metrics import frechet, joint_errors  # noqa: E402
from s2ag.core.learning.systems.system import System  # noqa: E402
from toy_bench import bench_of, write_tested_corpus  # noqa: E402

TINY = SETTINGS["tiny"]


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    torch.set_num_threads(1)
    return write_tested_corpus(tmp_path_factory.mktemp("data") / "corpus")


@pytest.fixture(scope="module")
def bench(corpus, tmp_path_factory):
    return bench_of(corpus, tmp_path_factory.mktemp("cache"), 60)


def quiet(text):
    pass


def test_intervals_hold_the_mean_of_talks_and_know_nothing_of_one():
    random = np.random.default_rng(0)
    talk = np.repeat(np.arange(12), 5)
    centres = random.normal(size=12)
    values = np.broadcast_to(centres.repeat(5) + 3, (1, 2, 60))
    low, high = significance.interval(values, talk)
    spread = centres.std() / np.sqrt(12)  # of the mean of twelve talks: windows of one are the same and add nothing
    assert low < values.mean() < high and high - low == pytest.approx(2 * 1.96 * spread, rel=0.15)
    holes = values.copy()
    holes[:, :, ::5] = np.nan
    assert significance.interval(holes, talk) == pytest.approx([low, high])
    assert significance.interval(values, np.zeros(60)) is None
    apart = np.stack([values[0], values[0] + 50])
    assert np.ptp(significance.interval(apart, talk)) == pytest.approx(50, abs=3)


def test_intervals_of_distances_resample_what_frechet_distances_are_of():
    random = np.random.default_rng(0)
    talk, real = np.repeat(np.arange(8), 20), random.normal(size=(160, 3))
    made = real + random.normal(size=160)[:, None] * [0.1, 0, 0] + [1, 0, 0]
    whole = significance.Moments.of(made, talk, 8).fit(np.ones((1, 8)))
    there = significance.Moments.of(real, talk, 8).fit(np.ones((1, 8)))
    assert frechet.distance_of_moments(*whole, *there, frechet.matrix_root(there[1]))[0] == pytest.approx(
        frechet.frechet_distance(made, real)
    )
    low, high = significance.distance_interval(made[None, None], real, talk)
    assert 0.8 < low < frechet.frechet_distance(made, real) < high < 1.3


def test_paired_tests_change_talks_and_not_windows():
    talk = np.repeat(np.arange(6), 50)
    ours = np.random.default_rng(0).normal(size=300)
    assert significance.paired_test(ours, ours + 1, talk) == pytest.approx(2 / 2**6)  # no windows' number makes it smaller
    assert significance.paired_test(ours, ours, talk) == 1.0
    swapped = ours + np.where(talk % 2, 1, -1)
    assert significance.paired_test(ours, swapped, talk) > 0.5
    many = np.arange(300) // 10
    assert significance.paired_test(ours, ours + 1, many) < 0.001


def test_paired_tests_of_distances_find_what_differs_in_all_talks():
    random = np.random.default_rng(0)
    talk, real = np.repeat(np.arange(8), 30), random.normal(size=(240, 2))
    near, far = (real + random.normal(size=(3, 240, 2)) * 0.2 + [[[shift, 0]]] for shift in (0.0, 2.0))
    assert significance.paired_distance_test(near, far[:2], real, talk) == pytest.approx(2 / 2**8)
    assert significance.paired_distance_test(near[:1], near[1:], real, talk) > 0.05


@pytest.mark.slow
def test_figures_by_window_are_those_of_the_table(bench):
    made = bench.real[::-1].copy()
    judged = bench.judge_draws(lambda draw: made, 2)
    for name in BY_WINDOW:
        assert np.nanmean(judged.windows[name][0]) == pytest.approx(judged.draws[0][name], rel=1e-5)
    assert judged.windows["maje_code"][1][7] == pytest.approx(joint_errors.maje_code(made[7:8], bench.real[7:8]), rel=1e-5)


def test_another_speech_is_one_of_another_recording_and_leaves_poses_and_speaker(bench):
    there = bench.elsewhere
    recording = bench.data.corpus.recording
    assert (recording[there[:, 0]] != bench.talk).all()
    assert sorted(map(tuple, there)) == sorted(map(tuple, bench.windows))

    class Listener(System):
        heard = []

        def perform(self, sample):
            self.heard.append(sample)
            return sample.directions

    system = Listener()
    assert np.array_equal(bench.perform(system, 1, heard=there), bench.real)
    heard = torch.cat([one.wave for one in system.heard])
    np.testing.assert_array_equal(heard, torch.from_numpy(bench.data.sounds(there).astype(np.float32) / 32768))
    own = bench.data.corpus.speaker[bench.windows[:, 0]]
    assert torch.cat([one.speaker for one in system.heard]).tolist() == own.tolist()


def test_one_recording_has_no_other_speech(corpus, bench):
    alone = Bench(bench.data, bench.extractor, 60)
    alone.windows = alone.windows[alone.talk == alone.talk[0]]
    assert alone.elsewhere is None


@pytest.mark.slow
def test_references_are_real_motion_of_the_same_talker_or_speech(bench):
    corpus, windows = bench.data.corpus, bench.windows
    talker, speech = references.same_talker(bench), references.same_speech(bench)
    assert (corpus.speaker[talker[:, 0]] == corpus.speaker[windows[:, 0]]).all()
    assert (corpus.recording[talker[:, 0]] != corpus.recording[windows[:, 0]]).all()
    assert (corpus.recording[speech[:, 0]] == corpus.recording[windows[:, 0]]).all()
    assert (speech[:, 0] != windows[:, 0]).all() and (speech[:, 1] == windows[:, 1]).all()
    alone = Bench(bench.data, bench.extractor, 60)
    alone.windows = alone.windows[alone.talk == alone.talk[0]]
    assert references.same_talker(alone) is None and references.same_speech(alone) is not None
    rows = references.reference_rows(bench)
    assert list(rows) == ["held", "mean", "talker", "speech", "real"]
    # The mean of what is to come is as near as stillness gets; motion that is real but not the window's own is farther.
    error = {name: row["figures"]["mpjpe"][0] for name, row in rows.items()}
    assert error["real"] == 0 < error["mean"] < min(error["held"], error["talker"])
    still = rows["mean"]["figures"]["l1_diversity"][0]
    assert still < rows["real"]["figures"]["l1_diversity"][0] and rows["speech"]["figures"]["cca"][0] > 0.5


@pytest.fixture(scope="module")
def trained(corpus, tmp_path_factory):
    """Three systems, two of them of two seeds."""
    folder = tmp_path_factory.mktemp("bench") / "b"
    assert Runner(folder, corpus, TINY, say=quiet).go(["seq2seq", "s2ag", "gtc"], "first")
    report = Runner(folder, corpus, TINY.replace(seeds=(1, 2)), say=quiet).go(["s2ag", "gtc"], "second")
    return folder, report


@pytest.mark.slow
def test_rows_have_seeds_of_their_own(trained):
    folder, report = trained
    assert {name: row["seeds"] for name, row in report["systems"].items()} == {"seq2seq": [1], "gtc": [1, 2], "s2ag": [1, 2]}
    text = (folder / "table.md").read_text()
    table = text.partition("## ")[0]
    cells = [[cell.strip() for cell in line.split("|")[1:4]] for line in table.splitlines() if line.startswith("| ")]
    assert ["Seq2Seq", "", "1"] in cells and ["S2AG", "random", "1, 2"] in cells and ["performed", "", ""] in cells
    for name, row in report["systems"].items():
        low, high = row["intervals"]["own"]["maje_code"]
        assert low <= row["figures"]["maje_code"][0] <= high
        assert set(row["against"]) == (set() if name == "s2ag" else {"maje_code", "mad_code", "fgd"})
    # Three talks change places in eight ways: no p is below a quarter, and two tests double it.
    assert all(value >= 0.25 for row in report["systems"].values() for value in row["against"].values())
    assert "## How sure that is" in text and "## Own speech against another's" in text
    gained = report["references"]["real"]["gains"]
    assert gained["maje_code"] > 0 and gained["cca"] > 0
    words = report["systems"]["seq2seq"]
    assert words["elsewhere"]["maje_code"][0] != words["figures"]["maje_code"][0]


@pytest.mark.slow
def test_the_table_of_a_folder_is_written_without_training(trained, capsys):
    folder, report = trained
    place = folder / "gtc-2"
    old = json.loads((place / "figures.json").read_text())
    (place / "windows.npz").unlink()  # as benches of before left it
    assert main(["bench", "--out", str(folder), "--threads", "1"]) == 0
    told = capsys.readouterr()
    again = json.loads((folder / "table.json").read_text())
    assert again["systems"]["gtc"]["seeds"] == [1, 2] and rows.is_evaluated(place)
    assert old["draws"]["own"][0]["maje_code"] == pytest.approx(again_of(place)["maje_code"])
    assert "± " in told.out and again["systems"]["gtc"]["steps"] == 3


def again_of(place):
    return json.loads((place / "figures.json").read_text())["draws"]["own"][0]


@pytest.mark.slow
def test_what_is_half_trained_is_left_out_and_said(corpus, tmp_path, capsys):
    assert Runner(tmp_path, corpus, TINY, say=quiet).go(["seq2seq"], "")
    calls = iter([False, False, True])
    runner = Runner(tmp_path, corpus, TINY, say=quiet)
    assert not runner.one("jem", 1, lambda: next(calls))
    assert main(["bench", "--out", str(tmp_path), "--threads", "1"]) == 0
    told = capsys.readouterr()
    assert "2 of 3 steps and left out" in told.err and "| JEM |" not in told.out


def test_a_bench_of_before_is_read_with_the_settings_it_had(corpus, tmp_path, capsys):
    Runner(tmp_path / "b", corpus, TINY, say=quiet)
    path = tmp_path / "b" / "setting.json"
    held = json.loads(path.read_text())
    for newer in ("given", "window", "hop"):
        held.pop(newer)
    path.write_text(json.dumps(held))
    assert Runner.opened(tmp_path / "b", say=quiet).setting == TINY == Runner(tmp_path / "b", corpus, TINY, say=quiet).setting
    assert main(["bench", "--out", str(tmp_path / "none")]) == 2 and "holds no bench" in capsys.readouterr().err
    assert main(["bench", "--out", str(tmp_path / "b")]) == 2 and "nothing that has been trained" in capsys.readouterr().err


@pytest.mark.slow
def test_half_of_a_window_may_be_given(corpus, tmp_path):
    """The paper's T seeds and next T (section 3.1.5)."""
    setting = TINY.replace(given=17, steps=1, draws=1)
    report = Runner(tmp_path, corpus, setting, say=quiet).go(["seq2seq", "s2g", "jem", "gesticulator", "s2ag"], "")
    assert "17 of a window's 34 poses are given" in (tmp_path / "table.md").read_text()
    bench = Runner(tmp_path, corpus, setting, say=quiet)._bench
    made = bench.real.copy()
    made[:, :17] *= 2
    assert bench.score(made)["maje_code"] == 0 and len(report["systems"]) == 5
    with pytest.raises(Exception, match="would be given"):
        Setting("odd", given=34)


@pytest.mark.parametrize("name", [rows.FIGURES, rows.WINDOWS])
def test_damaged_figures_are_a_sentence(tmp_path, name):
    folder = tmp_path / "seq2seq-1"
    folder.mkdir()
    (folder / rows.FIGURES).write_text("{}", encoding="utf-8")
    np.savez(folder / rows.WINDOWS, own_maje_code=np.zeros((1, 2)))
    assert rows.read_rows(tmp_path)[0].facts == [{}]
    (folder / name).write_bytes(b'{"draws": ')
    with pytest.raises(CorpusUnreadable, match="damaged"):
        rows.read_rows(tmp_path)
