"""What others bring to a bench: the authors' files end to end, motions, other benches' systems, the shipped network."""

import json
import pickle
import sys
import types

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.bench import external_rows  # noqa: E402
from s2ag.core.learning.bench.data import Data  # noqa: E402
from s2ag.core.learning.bench.evaluation import Bench  # noqa: E402
from s2ag.core.learning.bench.flow_networks import FlowPerformer, WindowFeatures, rhythm_of, words_of  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS  # noqa: E402
from s2ag.core.learning.metrics import extractor as extractors  # noqa: E402
from s2ag.core.learning.metrics.extractor import Extractor  # noqa: E402
from s2ag.core.learning.systems.imported import Imported  # noqa: E402
from s2ag.core.model import checkpoint, checkpoint_import, loading, paper_networks  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402
from s2ag.core.motion.motion import Motion  # noqa: E402
from s2ag.rigs import bvh  # noqa: E402
from sounds import write_wav  # noqa: E402
from toy_bench import bench_of, write_tested_corpus  # noqa: E402

TINY = SETTINGS["tiny"]
WORDS = ["<PAD>", "<SOS>", "<EOS>", "<UNK>", "gestures", "one", "of"]


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """Its speakers are called as two of the shipped network's."""
    torch.set_num_threads(1)
    return write_tested_corpus(tmp_path_factory.mktemp("data") / "corpus", speakers=[{"name": "stern"}, {"name": "tired"}])


@pytest.fixture(scope="module")
def bench(corpus, tmp_path_factory):
    return bench_of(corpus, tmp_path_factory.mktemp("cache"), 12)


@pytest.fixture
def authors(tmp_path):
    """Files as the authors of S2AG wrote them: generator, vocabulary, extractor. Nothing but their values is made up."""
    torch.manual_seed(3)
    generator = Generator(paper_networks.published(words=len(WORDS), speakers=3)).eval()
    state = dict(generator.state_dict())
    for name in list(state):
        for place, double in ((".conv1.", ".net.0."), (".conv2.", ".net.4.")):
            if name.startswith("text_encoder.tcn") and place in name:
                state[name.replace(place, double)] = state[name]
    torch.save({"gen_model_dict": state}, tmp_path / "epoch_000290_loss_-0.0048_model.pth.tar")
    module = types.ModuleType("authors_vocab")
    exec("class Vocab:\n    pass", module.__dict__)  # noqa: S102
    sys.modules["authors_vocab"] = module
    try:
        words = module.Vocab()
        words.word2index, words.n_words = {word: row for row, word in enumerate(WORDS)}, len(WORDS)
        (tmp_path / "vocab_cache.pkl").write_bytes(pickle.dumps(words))
    finally:
        del sys.modules["authors_vocab"]
    save_extractor(Extractor(), tmp_path / "embedding_net.pth.tar")
    return tmp_path


def save_extractor(net, path, key="embedding_dict"):
    """With the authors' names and the head for variances that nobody uses."""
    theirs = {}
    places = {"0": "net.0.0", "1": "net.0.1", "3": "net.1.0", "4": "net.1.1", "6": "net.2.0", "7": "net.2.1", "9": "net.3"}
    places |= {"11": "out_net.0", "12": "out_net.1", "14": "out_net.3", "15": "out_net.4", "17": "out_net.6", "18": "fc_mu"}
    for name, value in net.state_dict().items():
        part, row, rest = name.split(".", 2)
        if part == "encoder":
            theirs[f"pose_encoder.{places[row]}.{rest}"] = value
            if row == "18":
                theirs[f"pose_encoder.fc_log_var.{rest}"] = torch.randn_like(value)
        else:
            theirs[f"decoder.{'pre_net' if part == 'widen' else 'net'}.{row}.{rest}"] = value
    order = sorted(theirs, key=lambda name: "fc_log_var" in name and 0)  # as they were put in
    torch.save({key: {name: theirs[name] for name in order}, "epoch": 3}, path)


def test_the_authors_extractor_gives_the_same_features(tmp_path, bench):
    torch.manual_seed(5)
    net = Extractor().train()
    net(torch.from_numpy(bench.real))  # statistics of its own
    for key in ("embedding_dict", "gen_dict"):
        save_extractor(net.eval(), tmp_path / "net.bin", key)
        read = extractors.load_any(tmp_path / "net.bin")
        np.testing.assert_array_equal(read.features(bench.real), net.features(bench.real))
    torch.save({"gen_dict": {"a": torch.zeros(3)}}, tmp_path / "odd.bin")
    with pytest.raises(CheckpointUnreadable, match="no extractor of 34 frames"):
        extractors.load_any(tmp_path / "odd.bin")


@pytest.mark.parametrize("before", ["", "module."])
def test_the_extractor_of_beat2_is_refused_by_its_name(tmp_path, before):
    """EMAGE's autoencoder of the rotations of 55 joints; this project's poses do not hold them."""
    first = {f"{before}encoder.layers.0.0.residual.0.weight": torch.zeros(330, 330, 4)}
    torch.save({"model_state": first, "epoch": 100}, tmp_path / "AESKConv_240_100.bin")
    with pytest.raises(CheckpointUnreadable, match="BEAT2's extractor: it sees rotations of SMPL-X's 55 joints") as caught:
        extractors.load_any(tmp_path / "AESKConv_240_100.bin")
    assert "neither twists nor fingers" in caught.value.remedy


def test_imported_weights_hear_the_words_that_they_know(authors, bench):
    path = authors / "s2ag.safetensors"
    checkpoint_import.import_checkpoint(next(authors.glob("epoch*")), path, authors / "vocab_cache.pkl")
    words, speakers = bench.data.corpus.meta["words"], [one["name"] for one in bench.data.corpus.speakers]
    system = Imported(checkpoint.load(path), words, speakers).eval()
    assert system.rows.tolist() == [0, 1, 2, 3, 5, 3, 3, 6, 4]  # one beautiful day of gestures
    assert not system.known and Imported(checkpoint.load(path), words, ["speaker 2", "speaker 1"]).own.tolist() == [2, 1]
    sample = bench.data.sample(bench.windows[:3])
    torch.manual_seed(1)
    made = system.perform(sample)
    torch.manual_seed(1)
    generator = system.performer
    style = generator.sample_style(*generator.speaker(sample.speaker))
    torch.testing.assert_close(made, generator(sample.mfcc, system.rows[sample.words], sample.seeds, style))
    checkpoint_import.import_checkpoint(next(authors.glob("epoch*")), path)
    assert not Imported(checkpoint.load(path), words, speakers).rows.any()
    with pytest.raises(UsageError, match="does not perform windows of 34"):
        external_rows.external_row(
            path.with_name("other.safetensors") if save_ours(path.with_name("other.safetensors")) else "", bench, "cpu"
        )


def save_ours(path):
    return checkpoint.save(path, Generator(ModelConfig(word_size=300)), None, {"speakers": [{"name": "a", "description": ""}]})


@pytest.mark.slow
def test_the_authors_files_go_through_import_judging_and_the_study(authors, corpus, capsys):
    pytest.importorskip("bpy", reason="the package bpy is not installed")
    from s2ag.s2ag_blender.render import opengl

    if not opengl.is_available():
        pytest.skip("this machine offers no OpenGL, not even in software")
    file, out, talks = next(authors.glob("epoch*")), authors / "bench", authors / "talks"
    imported = authors / "s2ag.safetensors"
    assert main(["checkpoint", "import", str(file), "--vocabulary", str(authors / "vocab_cache.pkl"), "-o", str(imported)]) == 0
    judge = ["bench", "--data", str(corpus), "--out", str(out), "--setting", "tiny", "--threads", "1"]
    assert main([*judge, "--judge", f"theirs={file}"]) == 2 and "checkpoint import" in capsys.readouterr().err
    talks.mkdir()
    data = Data(corpus, out)
    for number in (4, 5, 6):
        sound = data.wave[data.wave_starts[number] : data.wave_starts[number + 1]] / 32768
        write_wav(authors / f"{number}.wav", sound)
        (authors / f"{number}.json").write_text(json.dumps(data.corpus.meta["recordings"][number]["words"]))
        command = ["synth", str(authors / f"{number}.wav"), "--transcript", str(authors / f"{number}.json")]
        assert main([*command, "--checkpoint", str(imported), "-o", str(talks / f"{number}.npz")]) == 0
    rows = [f"theirs={imported}", f"their talks={talks}"]
    extractor = ["--extractor", str(authors / "embedding_net.pth.tar")]
    assert main([*judge, *extractor, *(part for row in rows for part in ("--judge", row))]) == 0
    report = json.loads((out / "table.json").read_text())
    assert list(report["systems"]) == ["their talks", "theirs"] and report["systems"]["theirs"]["ids"] == "random"
    assert all(np.isfinite(row["figures"]["maje_code"]).all() for row in report["systems"].values())
    text = (out / "table.md").read_text()
    assert "- their talks: motions of talks, whole talks, no pose given" in text and "| theirs | random |" in text
    save_extractor(Extractor(), authors / "second.bin")
    assert main([*judge, "--extractor", str(authors / "second.bin")]) == 2
    assert "another extractor" in capsys.readouterr().err
    clips = authors / "clips"
    for name in ("theirs", "performed"):
        (clips / name).mkdir(parents=True)
    made = Motion.load(talks / "4.npz")
    Motion(made.directions[:15], made.fps).save(clips / "theirs" / "4.npz")
    bvh.save(Motion(data.motions(np.array([[8, 0]]))[0, :15]), clips / "performed" / "4.bvh")
    study = ["study", "make", str(clips), "-o", str(authors / "study"), "--character", "mannequin", "--speech", str(authors)]
    assert main(study) == 0
    key = json.loads((authors / "study" / "key.json").read_text())
    assert sorted(one["condition"] for one in key["clips"].values()) == ["performed", "theirs"]
    assert all((authors / "study" / "page" / "clips" / name).read_bytes()[4:8] == b"ftyp" for name in key["clips"])


def test_motions_are_judged_where_their_talks_windows_are(bench, tmp_path):
    corpus = bench.data.corpus
    for talk in np.unique(bench.windows[:, 0]):
        whole = corpus.directions[corpus.starts[talk] : corpus.starts[talk + 1]].astype(np.float32)
        name = f"{corpus.recording[talk]} {corpus.speakers[corpus.speaker[talk]]['name']}"
        Motion(np.repeat(whole, 2, 0), 30.0).save(tmp_path / f"{name}.npz")
    here = external_rows.external_row(tmp_path, bench, "cpu")
    np.testing.assert_allclose(here.perform(0, "own"), bench.real, atol=2e-3)
    assert here.ids == ("own",) and not here.draws and not here.answers
    first = next(tmp_path.glob("4 stern.npz"))
    Motion(whole[:100], 15.0).save(first)
    with pytest.raises(UsageError, match="ends after 6.7 s"):
        external_rows.external_row(tmp_path, bench, "cpu")
    first.unlink()
    with pytest.raises(UsageError, match="no motion for 1 of 6 test talks: 4"):
        external_rows.external_row(tmp_path, bench, "cpu")


@pytest.mark.slow
def test_trained_on_one_data_set_judged_on_another(corpus, bench, tmp_path):
    first = Runner(tmp_path / "a", corpus, TINY.replace(draws=1), say=lambda text: None)
    assert first.go(["seq2seq", "gtc"], "")
    facts = {"speakers": [{"name": "Ann"}, {"name": "Bob"}], "words": ["one", "beautiful", "gestures", "of", "day"]}
    other = write_tested_corpus(tmp_path / "other", seed=4, **facts)
    second = Runner(tmp_path / "b", other, TINY.replace(draws=1), say=lambda text: None)
    report = second.go([], "", judge={"words": str(tmp_path / "a" / "seq2seq-1"), "three": str(tmp_path / "a" / "gtc-1")})
    words, three = (report["systems"][name] for name in ("words", "three"))
    assert words["ids"] == "own" and three["ids"] == "random" and words["random_ids"] is None
    assert words["figures"]["maje_code"] != three["figures"]["maje_code"] and words["steps"] == 0
    # Of its own data set it gives what it gave there.
    again = Runner(tmp_path / "c", corpus, TINY.replace(draws=1), say=lambda text: None)
    again.use_extractor(tmp_path / "a" / "extractor.safetensors")
    same = again.go([], "", judge={"again": str(tmp_path / "a" / "seq2seq-1")})["systems"]["again"]["figures"]
    told = json.loads((tmp_path / "a" / "table.json").read_text())["systems"]["seq2seq"]["figures"]
    assert {name: same[name][0] for name in ("maje_code", "fgd")} == pytest.approx(
        {name: told[name][0] for name in ("maje_code", "fgd")}, rel=1e-4
    )
    with pytest.raises(UsageError, match="was given other poses"):
        Runner(tmp_path / "d", corpus, TINY.replace(given=9), say=lambda text: None).go(
            [], "", judge={"words": str(tmp_path / "a" / "seq2seq-1")}
        )


def test_the_shipped_network_performs_windows_from_the_poses_it_is_given(bench):
    few = Bench(bench.data, bench.extractor, 3)
    drawer = FlowPerformer()
    made, again = drawer.perform(few, 2), drawer.perform(few, 2)
    np.testing.assert_array_equal(made, again)
    np.testing.assert_allclose(made[:, :4], few.real[:, :4], atol=1e-5)
    assert drawer.knows(few) and external_rows.shipped_row(few).ids == ("own", "random")
    assert np.abs(made - drawer.perform(few, 2, "random")).max() > 0.01
    assert np.abs(made - drawer.perform(few, 2, "own", few.elsewhere)).max() > 0.01
    few.data.corpus.prosody, kept = few.data.corpus.prosody[:, :4], few.data.corpus.prosody
    try:
        with pytest.raises(UsageError, match="this network hears"):
            drawer.perform(few, 2)
    finally:
        few.data.corpus.prosody = kept


def test_the_shipped_network_is_finished_as_for_a_user(bench):
    """Gestures of phrases come from words with their times, which the network itself gets by other ways."""
    few, corpus = Bench(bench.data, bench.extractor, 2), bench.data.corpus
    drawer, known = FlowPerformer(), corpus.meta["recordings"]
    (one, _), first = few.windows[0], float(few.windows[0][1]) / 15
    said = [("so", first + 0.5, first + 0.8), ("big", first + 0.8, first + 1.3), ("before", first - 2.0, first - 1.0)]
    calm = [drawer.perform(few, seed) for seed in range(6)]
    corpus.meta["recordings"] = [{**facts, "words": said} for facts in known]
    try:
        assert words_of(corpus, one, int(few.windows[0][1]), 34) == (
            ("so", pytest.approx(0.5), pytest.approx(0.8)), ("big", pytest.approx(0.8), pytest.approx(1.3)),
        )  # fmt: skip
        shown = [drawer.perform(few, seed) for seed in range(6)]
        assert np.abs(np.array(shown) - calm).max() > 0.05  # in those takes whose chance shows this meaning
        for each in shown:
            np.testing.assert_allclose(each[:, :4], few.real[:, :4], atol=1e-5)
    finally:
        corpus.meta["recordings"] = known


def test_a_window_has_the_accents_that_a_recording_has_there(bench):
    corpus = bench.data.corpus
    assert rhythm_of(corpus, 0, 0, np.ones(34)) is None  # this data set knows none
    recording = int(corpus.recording[0])
    table = np.array([(0.2, 0.5, 0), (1.5, 0.9, 1), (2.9, 0.4, 0), (8.0, 0.7, 1)])
    corpus.arrays |= {"accents": np.tile(table, (recording + 1, 1)), "accent_starts": np.arange(recording + 2) * len(table)}
    try:
        found = rhythm_of(corpus, 0, 15, np.full(34, 0.5))
    finally:
        del corpus.arrays["accents"], corpus.arrays["accent_starts"]
    assert [(one.time, one.main) for one in found.accents] == [(pytest.approx(0.5), True), (pytest.approx(1.9), False)]
    np.testing.assert_allclose(found.phrases, [[0, 17 / 15]])


def test_a_window_hears_what_a_recording_holds_there(bench):
    talk, first = bench.windows[3]
    window = WindowFeatures(bench.data.corpus, talk, first, 34)
    mfcc, words, prosody = window.slice(0, 40)
    corpus, recording = bench.data.corpus, bench.data.corpus.recording[talk]
    rows = corpus.frame_starts[recording] + first + np.arange(34)
    np.testing.assert_array_equal(prosody, corpus.prosody[rows])
    assert not words[34:].any() and len(words) == 40 and words[:34].any()
    np.testing.assert_array_equal(mfcc[0], corpus.mfcc[corpus.mfcc_starts[recording] + round(first * 31.25 / 15)])
    assert loading.load().config.mfcc_features == mfcc.shape[1]


def test_rows_need_names_and_paths(corpus, tmp_path, capsys):
    common = ["bench", "--data", str(corpus), "--out", str(tmp_path / "b"), "--setting", "tiny"]
    for wrong in ("theirs", "=a", "s2ag=a", "default=a", "a/b=c"):
        assert main([*common, "--judge", wrong]) == 2 and "names no row and path" in capsys.readouterr().err
    assert main([*common, "--judge", f"a={tmp_path / 'none.safetensors'}"]) == 2
    assert "none.safetensors" in capsys.readouterr().err
