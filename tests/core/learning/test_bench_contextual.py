"""Gesticulator with vectors of words in their context, such as BERT's, that the user brings in a file."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.bench import contextual, external_rows  # noqa: E402
from s2ag.core.learning.bench.data import Data  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS  # noqa: E402
from s2ag.core.learning.systems.catalogue import ALL_SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.train.dataset import Corpus  # noqa: E402

NAME, WIDTH = "gesticulator-contextual", 12


def vectors(corpus):
    """By recording (its number: this data set names none), the number of the recording and of the word in the first columns."""
    made, random = {}, np.random.default_rng(0)
    for number, known in enumerate(json.loads((corpus / "meta.json").read_text())["recordings"]):
        made[str(number)] = random.normal(size=(len(known["words"]), WIDTH)).astype(np.float32)
        made[str(number)][:, 0], made[str(number)][:, 1] = number, np.arange(len(known["words"]))
    return made


@pytest.fixture
def file(corpus, tmp_path):
    np.savez(tmp_path / "bert.npz", **vectors(corpus))
    return tmp_path / "bert.npz"


def test_every_frame_has_the_vector_of_its_own_word(corpus, file, tmp_path):
    contextual.import_vectors(file, Corpus.load(corpus), tmp_path / "b" if (tmp_path / "b").mkdir() else tmp_path / "b")
    data = Data(corpus, tmp_path / "b", filtered=False)
    assert data.width == WIDTH
    talk, first = window = data.windows[0][11]
    found = data.sample(window[None]).contextual[0].numpy()
    recording = int(data.corpus.recording[talk])
    spoken = 0
    for frame in range(34):
        time = (first + frame) / 15
        words = data.corpus.meta["recordings"][recording]["words"]
        here = [number for number, (_, start, end) in enumerate(words) if start - 1e-6 <= time < end - 1e-6]
        assert (found[frame] == 0).all() if not here else found[frame, :2].tolist() == [recording, here[-1]]
        spoken += bool(here)
    assert 0 < spoken < 34 or spoken == 34


def test_the_system_hears_them_and_nothing_else_of_words(corpus, file, tmp_path):
    (tmp_path / "b").mkdir()
    contextual.import_vectors(file, Corpus.load(corpus), tmp_path / "b")
    data = Data(corpus, tmp_path / "b", filtered=False)
    torch.manual_seed(0)
    system = ALL_SYSTEMS[NAME].build(BuildOptions(data.vectors, data.speakers, 0.1, False, contextual=data.width)).eval()
    plain = ALL_SYSTEMS["gesticulator"].build(BuildOptions(data.vectors, data.speakers, 0.1, False, contextual=data.width))
    assert system.performer.frame[0].in_features == 64 + WIDTH + 5 and plain.performer.frame[0].in_features == 64 + 300 + 5
    sample = data.sample(data.windows[0][:4])
    with torch.inference_mode():
        made = system.perform(sample)
        sample.words[:] = 0
        assert torch.equal(system.perform(sample), made)
        sample.contextual[:] = 0
        assert not torch.equal(system.perform(sample), made)
    assert sample.to("cpu").contextual is not None


def test_what_does_not_fit_is_one_sentence(corpus, tmp_path, capsys):
    right = vectors(corpus)
    wrong = {
        "no array '0'": {name: one for name, one in right.items() if name != "0"},
        "not (": {**right, "0": right["0"][:-1]},
        "different widths": {**right, "0": right["0"][:, :5]},
        "no numbers or out of range": {**right, "0": right["0"] * np.nan},
        "the shape": {**right, "0": right["0"].astype(int)},
    }
    for says, arrays in wrong.items():
        np.savez(tmp_path / "wrong.npz", **arrays)
        (tmp_path / "b").mkdir(exist_ok=True)
        with pytest.raises(UsageError, match=says.replace("(", r"\(")):
            contextual.import_vectors(tmp_path / "wrong.npz", Corpus.load(corpus), tmp_path / "b")
        assert not list((tmp_path / "b").iterdir())
    (tmp_path / "wrong.npz").write_bytes(b"hello")
    command = ["bench", "--data", str(corpus), "--out", str(tmp_path / "c"), "--setting", "tiny", "--systems", NAME]
    for more, says in (
        ([], "this bench has none, give --contextual"),
        (["--contextual", str(tmp_path / "wrong.npz")], "holds no vectors for the words"),
        (["--contextual", str(tmp_path / "none.npz")], "holds no vectors for the words"),
    ):
        assert main([*command, *more]) == 2
        told = capsys.readouterr().err.strip().splitlines()[-1]
        assert says in told and "Traceback" not in told


def test_a_bench_keeps_them_and_takes_no_others(corpus, file, tmp_path):
    runner = Runner(tmp_path / "b", corpus, SETTINGS["tiny"], say=print)
    assert "none, give --contextual" in runner.unfit(NAME) and not runner.unfit("gesticulator")
    runner.use_contextual(file)
    assert not runner.unfit(NAME)
    file.rename(tmp_path / "moved.npz")
    again = Runner.opened(tmp_path / "b", say=print)
    again.use_contextual(tmp_path / "moved.npz")
    assert again.data.width == WIDTH and not again.unfit(NAME)
    np.savez(tmp_path / "others.npz", **{name: 2 * one for name, one in vectors(corpus).items()})
    with pytest.raises(UsageError, match="has other vectors"):
        again.use_contextual(tmp_path / "others.npz")
    kept = tmp_path / "b" / contextual.FOLDER / "row.npy"
    np.save(kept, np.load(kept)[:-1])
    with pytest.raises(CorpusUnreadable, match="is of other data"):
        Runner.opened(tmp_path / "b", say=print)
    kept.write_bytes(b"hello")
    with pytest.raises(CorpusUnreadable, match="is damaged"):
        Runner.opened(tmp_path / "b", say=print)


def test_a_system_with_them_is_not_judged_without(corpus, tmp_path):
    (tmp_path / f"{NAME}-1").mkdir()
    (tmp_path / "setting.json").write_text(json.dumps({"data": str(corpus), **SETTINGS["tiny"].to_dict()}))
    with pytest.raises(UsageError, match="which this bench lacks"):
        external_rows._load_trained(tmp_path / f"{NAME}-1", Data(corpus, tmp_path / "cache", filtered=False))


@pytest.mark.slow
def test_both_rows_of_gesticulator_from_the_command_line(corpus, file, tmp_path, capsys):
    command = ["bench", "--data", str(corpus), "--out", str(tmp_path / "b"), "--setting", "tiny", "--threads", "1"]
    assert main([*command, "--systems", f"gesticulator,{NAME}", "--contextual", str(file), "--jobs", "2"]) == 0
    assert "| Gesticulator with words in context |" in capsys.readouterr().out
    figures = json.loads((tmp_path / "b" / "table.json").read_text())["systems"]
    assert figures["gesticulator"]["figures"]["maje_code"] != figures[NAME]["figures"]["maje_code"]
