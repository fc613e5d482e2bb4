"""The authors' checkpoints: files in their layout give the same output, wrong ones are named, evil ones do nothing."""

import os
import pickle
import sys
import types
import zipfile

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable  # noqa: E402
from s2ag.core.model import checkpoint, checkpoint_import, loading, paper_networks, safe_pickle  # noqa: E402
from s2ag.core.model.discriminator import Discriminator  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402
from s2ag.core.synthesis.session import Request, Session  # noqa: E402

WORDS = ["<PAD>", "<SOS>", "<EOS>", "<UNK>", "hello", "world", "dont"]
VIDEOS = ["<UNK>", "talk-a", "talk-b"]


@pytest.fixture
def vocab_class():
    """A class in a module of the authors' name, so that pickles name what we do not have."""
    module = types.ModuleType("authors_vocab")
    exec("class Vocab:\n    pass", module.__dict__)  # noqa: S102
    sys.modules["authors_vocab"] = module
    yield module.Vocab
    del sys.modules["authors_vocab"]


def vocab(kind, names):
    made = kind()
    made.name, made.trimmed, made.n_words = "words", False, len(names)
    made.word2index = {name: row for row, name in enumerate(names)}
    made.index2word = dict(enumerate(names))
    made.word_embedding_weights = np.zeros((len(names), 300), np.float32)
    return made


def networks(preset, **changes):
    torch.manual_seed(0)
    config = preset(words=len(WORDS), speakers=len(VIDEOS), **changes)
    generator = Generator(config)
    for name, buffer in generator.named_buffers():
        if "running" in name:
            buffer.uniform_(0.5, 1.5)
    return generator.eval(), Discriminator(config).eval()


def authors_state(module, gtc=False):
    """Their names: the text encoder's convolutions twice, GTC's variance without an underscore."""
    state = {name: value for name, value in module.state_dict().items()}
    for name in list(state):
        for place, double in ((".conv1.", ".net.0."), (".conv2.", ".net.4.")):
            if name.startswith("text_encoder.tcn") and place in name:
                state[name.replace(place, double)] = state[name]
    if gtc:
        state = {name.replace("speaker_log_var", "speaker_logvar"): value for name, value in state.items()}
    return state


def outputs(generator):
    torch.manual_seed(5)
    wave = generator.config.audio == "wave"
    sound = torch.randn(2, 36267) if wave else torch.randn(2, 37, 71)
    words = torch.randint(0, len(WORDS), (2, 34))
    with torch.inference_mode():
        style, spread = generator.speaker(torch.tensor([1, 2]))
        return generator(sound, words, torch.randn(2, 34, 28), style), spread


@pytest.mark.parametrize("legacy", [False, True])
def test_s2ag_gives_the_same_output(tmp_path, legacy):
    generator, discriminator = networks(paper_networks.published)
    path = tmp_path / "epoch_000290_loss_-0.0048_model.pth.tar"
    state = {"gen_model_dict": authors_state(generator), "dis_model_dict": discriminator.state_dict()}
    torch.save(state, path, _use_new_zipfile_serialization=not legacy)
    checkpoint_import.import_checkpoint(path, tmp_path / "s2ag.safetensors")
    loaded = checkpoint.load(tmp_path / "s2ag.safetensors")
    assert loaded.config == generator.config and loading.load(tmp_path / "s2ag.safetensors").window == (34, 4)
    for one, two in zip(outputs(generator), outputs(loaded.generator), strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)
    motion = torch.randn(2, 34, 9, 3)
    torch.testing.assert_close(discriminator(motion), loaded.discriminator(motion), rtol=0, atol=0)
    assert [one["name"] for one in loaded.speakers] == ["untrained", "speaker 1", "speaker 2"]


@pytest.mark.parametrize("wrapped", ["", "module."])
def test_gtc_gives_the_same_output_and_brings_its_lists(tmp_path, vocab_class, wrapped):
    generator, discriminator = networks(paper_networks.trimodal, head_slope=1.0)
    path = tmp_path / "multimodal_context_checkpoint_best.bin"
    state = {wrapped + name: value for name, value in authors_state(generator, gtc=True).items()}
    facts = {"lang_model": vocab(vocab_class, WORDS), "speaker_model": vocab(vocab_class, VIDEOS), "epoch": 86, "pose_dim": 27}
    torch.save({**facts, "gen_dict": state, "dis_dict": discriminator.state_dict()}, path)
    checkpoint_import.import_checkpoint(path, tmp_path / "gtc.safetensors")
    loaded = checkpoint.load(tmp_path / "gtc.safetensors")
    assert loaded.config.head_slope == 1.0 and loaded.config.audio == "wave"
    for one, two in zip(outputs(generator), outputs(loaded.generator), strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=0)
    assert loaded.meta["vocabulary"] == WORDS
    assert [one["name"] for one in loaded.speakers] == ["untrained", "talk-a", "talk-b"]


@pytest.mark.parametrize("preset", [paper_networks.without_mfcc, paper_networks.without_affect])
def test_ablations_are_recognised(tmp_path, preset):
    generator, _ = networks(preset)
    torch.save({"gen_model_dict": authors_state(generator)}, tmp_path / "a.pth.tar")
    checkpoint_import.import_checkpoint(tmp_path / "a.pth.tar", tmp_path / "a.safetensors")
    loaded = checkpoint.load(tmp_path / "a.safetensors")
    assert loaded.config == generator.config and loaded.discriminator is None
    torch.testing.assert_close(outputs(generator)[0], outputs(loaded.generator)[0], rtol=0, atol=0)


def test_gtc_as_s2ag_stores_it(tmp_path):
    generator, _ = networks(paper_networks.trimodal, head_slope=1.0)
    torch.save({"trimodal_gen_dict": authors_state(generator)}, tmp_path / "trimodal_gen.pth.tar")
    checkpoint_import.import_checkpoint(tmp_path / "trimodal_gen.pth.tar", tmp_path / "t.safetensors")
    loaded = checkpoint.load(tmp_path / "t.safetensors")
    torch.testing.assert_close(outputs(generator)[0], outputs(loaded.generator)[0], rtol=0, atol=0)


def test_every_mismatch_is_named(tmp_path):
    generator, _ = networks(paper_networks.published)
    state = authors_state(generator)
    del state["gru.bias_hh_l2"]
    state["head.weight"] = torch.zeros(3)
    state["out.2.weight"] = torch.zeros(27, 75)
    torch.save({"gen_model_dict": state}, tmp_path / "x.pth.tar")
    with pytest.raises(CheckpointUnreadable) as error:
        checkpoint_import.import_checkpoint(tmp_path / "x.pth.tar", tmp_path / "x.safetensors")
    for part in ("missing: gru.bias_hh_l2", "unknown: head.weight", "out.2.weight is (27, 75), not (27, 150)"):
        assert part in str(error.value)
    assert not (tmp_path / "x.safetensors").exists()
    state = authors_state(generator)
    state["text_encoder.tcn.network.1.net.4.weight_v"] = state["text_encoder.tcn.network.1.net.4.weight_v"] + 1
    torch.save({"gen_model_dict": state}, tmp_path / "y.pth.tar")
    with pytest.raises(CheckpointUnreadable, match="network.1.net.4.weight_v than under their twins"):
        checkpoint_import.import_checkpoint(tmp_path / "y.pth.tar", tmp_path / "y.safetensors")


def test_other_files_are_one_sentence(tmp_path, capsys):
    (tmp_path / "noise.bin").write_bytes(b"no weights")
    torch.save({"epoch": 3}, tmp_path / "empty.bin")
    torch.save([1, 2], tmp_path / "list.bin")
    torch.save({"gen_dict": {"a.weight": torch.zeros(2)}}, tmp_path / "other.bin")
    for name, sentence in (
        ("absent", "no checkpoint"),
        ("noise", "cannot be read"),
        ("empty", "holds none of"),
        ("list", "no dictionary"),
        ("other", "text_encoder.embedding.weight is missing"),
    ):
        assert main(["checkpoint", "import", str(tmp_path / f"{name}.bin"), "-o", str(tmp_path / "o.safetensors")]) == 2
        said = capsys.readouterr().err
        assert sentence in said and "Traceback" not in said


class Evil:
    def __reduce__(self):
        return os.system, ("echo ran > " + os.environ["S2AG_EVIL"],)


def test_nothing_in_a_file_is_run(tmp_path, monkeypatch):
    target = tmp_path / "ran"
    monkeypatch.setenv("S2AG_EVIL", str(target))
    generator, _ = networks(paper_networks.published)
    torch.save({"gen_model_dict": authors_state(generator), "args": Evil()}, tmp_path / "evil.pth.tar")
    with pytest.raises(CheckpointUnreadable, match="cannot be read"):
        checkpoint_import.import_checkpoint(tmp_path / "evil.pth.tar", tmp_path / "e.safetensors")
    found = safe_pickle.read(pickle.dumps({"x": Evil(), "y": [1, 2]}))
    assert isinstance(found["x"], safe_pickle.Record) and type(found["x"]).__name__ == "system" and found["y"] == [1, 2]
    assert not target.exists()
    for call in (b"cbuiltins\neval\n(S'1+1'\ntR.", b"c__builtin__\ngetattr\n(cnumpy\nndarray\nS'dumps'\ntR."):
        assert isinstance(safe_pickle.read(call), safe_pickle.Record)
    with pytest.raises(safe_pickle.PickleUnreadable, match="cannot be read"):
        safe_pickle.read(b"\x80\x04nothing")


def test_old_and_new_pickles_of_arrays_and_records(vocab_class):
    table = np.random.default_rng(0).normal(size=(3, 4)).astype(np.float32)
    for protocol in (0, 2, 4):
        found = safe_pickle.read(pickle.dumps([vocab(vocab_class, WORDS), table, np.float64(2.5)], protocol))
        assert found[0].get("word2index")["world"] == 5
        np.testing.assert_array_equal(found[1], table)
        assert found[2] == 2.5


def test_imported_networks_perform_like_any_other(tmp_path, vocab_class, examples):
    generator, _ = networks(paper_networks.published)
    torch.save({"gen_model_dict": authors_state(generator)}, tmp_path / "s.pth.tar")
    (tmp_path / "vocab_cache.pkl").write_bytes(pickle.dumps(vocab(vocab_class, WORDS)))
    command = ["checkpoint", "import", str(tmp_path / "s.pth.tar"), "-o", str(tmp_path / "s.safetensors")]
    assert main([*command, "--vocabulary", str(tmp_path / "vocab_cache.pkl")]) == 0
    session = Session(tmp_path / "s.safetensors")
    request = Request(examples / "hello.flac", text=(examples / "hello.txt").read_text(), seed=2)
    one, two = (session.synthesize(request).motions[0].directions for _ in range(2))
    np.testing.assert_array_equal(one, two)
    assert len(one) > 200 and np.isfinite(one).all()
    np.testing.assert_allclose(np.linalg.norm(one, axis=-1), 1, atol=1e-4)
    mute = session.synthesize(Request(examples / "hello.flac", seed=2)).motions[0].directions
    assert np.abs(mute - one).max() > 1e-4
    assert main(command) == 0
    plain = Session(tmp_path / "s.safetensors").synthesize(request)
    assert any("without its vocabulary" in warning for warning in plain.warnings)


def test_gtc_performs_from_raw_sound(tmp_path, examples):
    generator, _ = networks(paper_networks.trimodal, head_slope=1.0)
    torch.save({"gen_dict": authors_state(generator, gtc=True)}, tmp_path / "g.bin")
    checkpoint_import.import_checkpoint(tmp_path / "g.bin", tmp_path / "g.safetensors")
    motion = Session(tmp_path / "g.safetensors").synthesize(Request(examples / "hello.flac")).motions[0]
    assert np.isfinite(motion.directions).all()


def test_a_wrong_vocabulary_is_refused(tmp_path, vocab_class):
    generator, _ = networks(paper_networks.published)
    torch.save({"gen_model_dict": authors_state(generator)}, tmp_path / "s.pth.tar")
    for name, content, sentence in (
        ("long", vocab(vocab_class, WORDS * 1 + ["more"]), "the network's table 7"),
        ("odd", [1], "no Vocab"),
    ):
        (tmp_path / name).write_bytes(pickle.dumps(content))
        with pytest.raises(CheckpointUnreadable, match=sentence):
            checkpoint_import.import_checkpoint(tmp_path / "s.pth.tar", tmp_path / "s.safetensors", tmp_path / name)


# --- hostile files


def test_members_that_inflate_without_limit_are_refused(tmp_path):
    path = tmp_path / "bomb.pth"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("bomb/data.pkl", b"\x80\x02" + b"N0" * 5_000_000 + b"N.")
    assert path.stat().st_size < 100_000
    with pytest.raises(CheckpointUnreadable, match="unpacks to more"):
        checkpoint_import.read(path)


def doubled(times, end):
    """A pickle of a tuple of the same tuple twice, and so on: a few bytes that are endless to whoever walks them all."""
    steps = b"".join(b"h" + bytes([n]) + b"h" + bytes([n]) + b"\x86\x94" for n in range(times))
    return b"\x80\x04N\x94" + steps + end


@pytest.mark.parametrize(
    "data",
    [
        doubled(60, b"}h\x3cNs."),  # as a key of a dictionary
        doubled(60, b"\x8f(h\x3c\x90."),  # in a set
        doubled(60, b"cbuiltins\nfrozenset\nh\x3c\x85R."),
        b"\x80\x04(" + b"N" * 100_000 + b"t\x94" + b"cbuiltins\nlist\nh\x00\x85R" * 20_000 + b".",  # 16 GB of copies
        b"\x80\x02cnumpy.core.multiarray\nscalar\ncnumpy\ndtype\nU\x02f8K\x00K\x01\x87RJ\xff\xff\xff\x7f\x86R.",
    ],
)
def test_pickles_that_loop_or_grow_are_one_sentence(data):
    with pytest.raises(safe_pickle.PickleUnreadable):
        safe_pickle.read(data)


def test_what_nests_may_be_a_value():
    assert safe_pickle.read(doubled(3, b".")) == (((None, None), (None, None)), ((None, None), (None, None)))
