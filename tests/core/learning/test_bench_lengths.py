"""Data sets of another frame rate and windows of another length, from the reader to the table."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from rounding import same_figures  # noqa: E402
from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.bench import external_rows, flow_networks  # noqa: E402
from s2ag.core.learning.bench.data import Data  # noqa: E402
from s2ag.core.learning.bench.evaluation import Bench  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS, Setting  # noqa: E402
from s2ag.core.learning.bench.weights import save as save_weights  # noqa: E402
from s2ag.core.learning.datasets import writer  # noqa: E402
from s2ag.core.learning.datasets.recording import Recording  # noqa: E402
from s2ag.core.learning.metrics.extractor import Extractor  # noqa: E402
from s2ag.core.learning.metrics.rhythm import angle_changes  # noqa: E402
from s2ag.core.learning.systems.catalogue import ALL_SYSTEMS, SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.systems.lengths import PUBLISHED, Lengths  # noqa: E402
from s2ag.core.learning.train.dataset import Corpus  # noqa: E402
from s2ag.core.model.mfcc_timing import nearest_mfcc  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402
from toy_bench import write_bench_corpus  # noqa: E402

FPS, WINDOW, HOP = 25.0, 40, 7
RAW = ("gtc", "s2ag-no-mfcc", "jem")
"""Systems whose encoder of raw audio makes 34 frames, and no other number."""
FIT = [name for name in ALL_SYSTEMS if name not in RAW and not ALL_SYSTEMS[name].contextual]


def recordings(seconds=12):
    """Six talks of two speakers; the arms swing as slow waves, so that a rate shows."""
    rng = np.random.default_rng(0)
    for number, split in enumerate(("train", "train", "train", "train", "validation", "test")):
        time = np.arange(int(seconds * FPS)) / FPS
        swing = 0.5 * np.sin(2 * np.pi * (0.4 + 0.1 * number) * time)[:, None, None]
        directions = skeleton.normalize(skeleton.MEAN_UNIT + swing * rng.normal(size=(1, 9, 3)))
        words = [(word, a + 2 * at, b + 2 * at) for at in range(5) for word, a, b in (("one", 0.5, 0.9), ("day", 1.3, 1.9))]
        sound = rng.normal(0, 0.1, seconds * 16000).astype(np.float32)
        yield Recording(f"talk{number}", sound, words, directions, f"s{number % 2}", split)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    torch.set_num_threads(1)
    folder = tmp_path_factory.mktemp("data") / "corpus"
    writer.write(recordings(), folder, "test", fps=FPS)
    return folder


@pytest.fixture(scope="module")
def data(corpus, tmp_path_factory):
    return Data(corpus, tmp_path_factory.mktemp("cache"), filtered=False, window=WINDOW, hop=HOP)


def test_lengths_of_the_public_codes():
    assert (PUBLISHED.samples, PUBLISHED.cepstra, PUBLISHED.published) == (36267, 71, True)
    other = Lengths(WINDOW, FPS)
    assert (other.samples, other.cepstra, other.published, str(other)) == (25600, 50, False, "40 frames at 25 a second")
    assert nearest_mfcc(np.array([0, 4, 5, 25]), FPS).tolist() == [0, 5, 6, 31]  # 1.25 MFCC frames a pose, halves up
    assert nearest_mfcc(30, 29.97) == 31


def test_a_data_set_keeps_its_rate(corpus):
    arrays = Corpus.load(corpus, any_rate=True)
    assert arrays.fps == FPS and (np.diff(arrays.starts) == 300).all() and arrays.prosody.shape == (1800, 17)
    assert (arrays.word_index[12:23] == 0).all() and arrays.word_index[11] == arrays.word_index[23] == -1  # 0.5 to 0.9 s
    with pytest.raises(CorpusUnreadable, match="25 pose frames a second, and networks for use are trained at 15"):
        Corpus.load(corpus)


def test_windows_hold_what_was_heard_and_performed(data):
    assert (np.diff(data.windows[0][:5, 1]) == HOP).all() and data.windows[0][:, 1].max() + WINDOW <= 300
    talk, first = window = data.windows[0][9]
    sample, corpus = data.sample(window[None]), data.corpus
    rows = corpus.starts[talk] + first + np.arange(WINDOW)
    np.testing.assert_allclose(sample.directions[0], corpus.directions[rows].astype(np.float32), atol=2e-3)
    begin = data.wave_starts[corpus.recording[talk]] + round(first * 16000 / FPS)
    np.testing.assert_allclose(sample.wave[0] * 32768, data.wave[begin : begin + 25600])
    heard = corpus.mfcc_starts[corpus.recording[talk]] + round(first / FPS * 31.25)
    np.testing.assert_array_equal(sample.cepstra[0], data.cepstra[heard : heard + 50].astype(np.float32))
    known = corpus.meta["recordings"][corpus.recording[talk]]["words"]
    onsets = [int(np.floor(start * FPS + 1e-6)) - first for _, start, _ in known]
    onsets = [place for place in onsets if 0 < place < WINDOW]
    assert (sample.words[0, onsets] >= 4).all() and (sample.words[0, 1:] > 0).sum() == len(onsets) > 0


@pytest.mark.parametrize("name", FIT)
def test_systems_learn_and_perform_windows_of_any_length(data, name):
    torch.manual_seed(0)
    system = ALL_SYSTEMS[name].build(BuildOptions(data.vectors, data.speakers, 0.05, False, 0.25, lengths=data.lengths)).train()
    assert ALL_SYSTEMS[name].unfit(data.lengths) == ""
    sample = data.sample(data.windows[0][::7][:4])
    made = system.make(sample, 0.5)
    terms = system.terms(sample, made, 0.5)
    if system.judge_active(0.5):
        terms["judge"] = system.judge_loss(sample, made.directions.detach())
    sum(terms.values()).backward()
    gradients = [p.grad for p in system.performer.parameters() if p.requires_grad and p.grad is not None]
    assert gradients and all(part.isfinite().all() for part in gradients)
    with torch.inference_mode():
        assert system.eval().perform(sample).shape == sample.directions.shape == (4, WINDOW, 9, 3)


def test_what_takes_no_other_windows_says_so(data, corpus, tmp_path):
    for name in RAW:
        reason = ALL_SYSTEMS[name].unfit(data.lengths)
        assert "its encoder makes 34 frames at 15 a second: these windows have 40 frames at 25 a second." in reason
        assert ALL_SYSTEMS[name].unfit(PUBLISHED) == "" != ALL_SYSTEMS[name].unfit(Lengths(34, 25.0))
    assert "needs windows of 32 frames" in ALL_SYSTEMS["s2g"].unfit(Lengths(31, 15.0))
    said = []
    setting = SETTINGS["tiny"].replace(window=WINDOW, hop=HOP)
    runner = Runner(tmp_path / "b", corpus, setting, say=said.append)
    assert runner.fitting([*SYSTEMS, "default"]) == ["seq2seq", "s2g", "gesticulator", "s2ag-no-affect", "s2ag"]
    assert len(said) == 4 and "perform 15 frames a second: this data set has 25" in said[-1]
    for name in ("gtc", "default"):
        with pytest.raises(UsageError, match="frames at 25|has 25"):
            runner.go([name], "")
    assert not flow_networks.why_unfit(Lengths(60, 15.0))
    Extractor().save(tmp_path / "of34.safetensors")
    with pytest.raises(UsageError, match="sees 34 frames: these windows have 40"):
        runner.use_extractor(tmp_path / "of34.safetensors")
    torch.manual_seed(0)
    system = ALL_SYSTEMS["s2ag"].build(BuildOptions(data.vectors, data.speakers, 0.05, False, lengths=data.lengths))
    assert save_weights(system, data, tmp_path, {}) is None


def test_an_extractor_remembers_its_length(tmp_path):
    torch.manual_seed(0)
    made, motions = Extractor(frames=WINDOW).eval(), np.random.default_rng(0).normal(size=(3, WINDOW, 9, 3))
    made.save(tmp_path / "e.safetensors")
    again = Extractor.load(tmp_path / "e.safetensors")
    assert again.frames == WINDOW and again(torch.from_numpy(motions).float()).shape == (3, WINDOW, 9, 3)
    np.testing.assert_array_equal(again.features(motions), made.features(motions))


@pytest.mark.slow
def test_figures_a_second_know_the_rate(data):
    """The same poses at 25 a second are 25 / 15 times as fast as at 15."""
    torch.manual_seed(0)
    bench = Bench(data, Extractor(frames=WINDOW).eval(), 12)
    made = bench.real[::-1].copy()
    fast = bench.judge(made)
    bench.fps = 15.0
    slow = bench.judge(made)
    for name, power in {"acceleration": 2, "jerk": 3, "mad_seconds": 2, "mad_norm": 2, "mad_code": 0, "maje_code": 0}.items():
        assert fast[name] == pytest.approx(slow[name] * (FPS / 15) ** power), name
    np.testing.assert_allclose(angle_changes(made, FPS), angle_changes(made) * FPS / 15)


def test_settings_of_windows_are_checked():
    for wrong in ({"window": 15}, {"window": 601}, {"hop": 0}, {"hop": 35}, {"given": 33}):
        with pytest.raises(UsageError, match="out of range|would be given"):
            Setting("odd", **wrong)
    assert Setting("even", window=60, given=30, hop=60).given == 30


def test_a_bench_belongs_to_the_rate_that_it_was_begun_with(data, corpus, tmp_path):
    setting = SETTINGS["tiny"].replace(window=WINDOW, hop=HOP)
    Runner(tmp_path / "b", corpus, setting, say=print)
    assert json.loads((tmp_path / "b" / "setting.json").read_text())["fps"] == FPS
    assert Runner.opened(tmp_path / "b", say=print).data.lengths == data.lengths
    same = write_bench_corpus(tmp_path / "same")
    Runner(tmp_path / "c", same, SETTINGS["tiny"], say=print)
    assert "fps" not in json.loads((tmp_path / "c" / "setting.json").read_text())
    meta = json.loads((same / "meta.json").read_text())
    (same / "meta.json").write_text(json.dumps(meta | {"fps": 16}))
    with pytest.raises(UsageError, match="other settings or data"):
        Runner(tmp_path / "c", same, SETTINGS["tiny"], say=print)
    (tmp_path / "c" / "setting.json").write_text('{"data": 5}')
    with pytest.raises(UsageError, match="setting.json is damaged"):
        Runner.opened(tmp_path / "c", say=print)


def test_a_system_of_other_windows_is_not_judged(data, corpus, tmp_path):
    (tmp_path / "seq2seq-1").mkdir()
    held = {"data": str(corpus), **SETTINGS["tiny"].replace(window=WINDOW).to_dict()}
    (tmp_path / "setting.json").write_text(json.dumps(held))
    with pytest.raises(UsageError, match="learned from windows of 40 frames at 15 a second"):
        external_rows._load_trained(tmp_path / "seq2seq-1", data)


def test_the_command_converts_at_a_rate_and_refuses_in_a_sentence(tmp_path, capsys):
    for command, sentence in (
        (["directed", str(tmp_path), "--speech", str(tmp_path), "--fps", "25"], "was performed at 15 frames a second"),
        (["ted", str(tmp_path), "--fps", "500"], "out of range"),
        (["ted", str(tmp_path), "--fps", "nan"], "out of range"),
    ):
        assert main(["data", *command, "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert sentence in said and said.count("\n") == 1


@pytest.mark.slow
def test_a_table_of_other_windows(corpus, tmp_path, capsys):
    command = ["bench", "--data", str(corpus), "--setting", "tiny", "--threads", "1", "--window", "40", "--hop", "7"]
    assert main([*command, "--out", str(tmp_path / "b")]) == 0
    told = capsys.readouterr()
    assert "Windows of 40 frames every 7, 25 frames a second." in told.out and "Left out: GTC hears raw audio" in told.err
    report = json.loads((tmp_path / "b" / "table.json").read_text())
    assert list(report["systems"]) == ["seq2seq", "s2g", "gesticulator", "s2ag-no-affect", "s2ag"]
    assert main(["bench", "--out", str(tmp_path / "b"), "--threads", "1"]) == 0
    again = json.loads((tmp_path / "b" / "table.json").read_text())
    same_figures(*({name: row["figures"] for name, row in one["systems"].items()} for one in (report, again)))
