"""The acoustic model in numpy, and its alignment beside pocketsphinx's."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import sphinx_files
from s2ag.core.errors import EngineMissing
from s2ag.core.sound import audio
from s2ag.core.words import align, language
from s2ag.core.words.aligner import (
    acoustic,
    cepstra,
    engines,
    graph,
    lexicon,
    numpy_engine,
    packed_model,
    sphinx_engine,
    sphinx_model,
    viterbi,
)


@pytest.fixture(scope="module")
def model():
    return acoustic.AcousticModel(packed_model.read())


@pytest.fixture(scope="module")
def theirs():
    """The folder of pocketsphinx's English model."""
    return Path(pytest.importorskip("pocketsphinx", reason="it is not installed").get_model_path()) / "en-us"


def test_what_comes_with_us_is_pocketsphinxs(theirs, hello):
    mine, whole = packed_model.read(), sphinx_model.read(theirs / "en-us")
    for name in mine._fields:
        if name == "means":
            np.testing.assert_allclose(mine.means, whole.means, rtol=1e-3, atol=1e-6)
        elif name == "variances":
            np.testing.assert_allclose(mine.variances, np.maximum(whole.variances, 1e-4), rtol=0.01)
        else:
            np.testing.assert_array_equal(getattr(mine, name), getattr(whole, name))
    sound = (hello[0][:80000] * 20000).astype(np.int16)
    one, other = (acoustic.AcousticModel(parts) for parts in (mine, whole))
    senones = one.together(np.arange(0, 5000, 50))
    scores = [model.scores(model.hear(cepstra.features(sound), 4), senones) for model in (one, other)]
    apart = np.abs(scores[0] - scores[1])
    assert apart.mean() < 0.03 and np.percentile(apart, 98) < 0.1


def test_the_dictionary_is_pocketsphinxs(theirs):
    lines = [line.split(None, 1) for line in (theirs / "cmudict-en-us.dict").read_text("utf-8").splitlines()]
    ways = {}
    for word, way in lines:
        ways.setdefault(word.partition("(")[0], []).append(way.strip())
    assert packed_model.pronunciations(set(ways)) == ways
    assert packed_model.pronunciations({"hello", "qwzx"}) == {"hello": ways["hello"]}


def test_a_damaged_model_is_told(tmp_path):
    path = tmp_path / "english.npz"
    for content in (b"", packed_model.ENGLISH.read_bytes()[:9000]):
        path.write_bytes(content)
        with pytest.raises(sphinx_model.UnreadableModel):
            packed_model.read(path)


@pytest.fixture(scope="module")
def hello(examples):
    return audio.load(examples / "hello.flac"), json.loads((examples / "hello.json").read_text())


def test_the_model_is_what_its_files_say(model):
    assert len(model.phones) == 42 and model.phones["SIL"] == model.silence
    assert model.alone.shape == (42, 3) and model.alone.max() < 126
    np.testing.assert_allclose(np.exp(model.stay) + np.exp(model.leave), 1, atol=1e-5)
    k, ae, t = (model.phones[name] for name in ("K", "AE", "T"))
    between = model.triphone(ae, k, t, acoustic.INSIDE)
    assert min(between) >= 126 and between != model.triphone(ae, t, k, acoustic.INSIDE)
    never = model.triphone(model.silence, k, t, acoustic.INSIDE)
    assert never == tuple(model.alone[model.silence])


@pytest.mark.parametrize("best", [1, 4, 128])
def test_scores_are_those_of_gaussian_mixtures(model, best):
    """Against the formula itself, one senone at a time, from the files' own numbers."""
    features = cepstra.features(np.random.default_rng(0).normal(0, 3000, 4000).astype(np.int16))
    senones = model.together(np.array([7, 300, 5000]))
    found = model.scores(model.hear(features, best), senones)
    means, variances = (part.astype(float) for part in (packed_model.read().means, packed_model.read().variances))
    expected = np.zeros_like(found, dtype=float)
    heard = np.split(features, 3, axis=1)

    def densities(stream, books):
        mean, variance = means[books, stream], np.maximum(variances[books, stream], 1e-4)
        return -0.5 * ((heard[stream][:, None, None] - mean) ** 2 / variance + np.log(2 * np.pi * variance)).sum(-1)

    deepest = [densities(stream, slice(None)).max(axis=(1, 2)) - 96 * acoustic.STEP for stream in range(3)]
    for column, senone in enumerate(senones):
        book = model._book[senone]
        for stream in range(3):
            density = densities(stream, [book])[:, 0]
            shares = -0.1024 * model._weights[stream, :, senone]
            order = np.argsort(-density, axis=1)[:, :best]
            density = np.maximum(density, deepest[stream][:, None])
            expected[:, column] += np.logaddexp.reduce(np.take_along_axis(density + shares, order, axis=1), axis=1)
    np.testing.assert_allclose(found, expected, atol=0.05)


def test_a_path_visits_words_in_order(model, hello):
    sound, _ = hello
    heard = model.hear(cepstra.features((sound[:48000] * 20000).astype(np.int16)), 1)
    ways = [[tuple(model.phones[name] for name in way.split())] for way in ("HH AH L OW", "AY", "M EY D")]
    background = np.zeros(len(heard.which))
    said = viterbi.best_path(model, graph.build_graph(model, ways), heard, background)
    assert [part.word for part in said] == [0, 1, 2]
    assert all(one.end <= other.begin for one, other in zip(said, said[1:], strict=False))
    for manner in ({"open_end": True}, {"jump": -30.0}):
        assert viterbi.best_path(model, graph.build_graph(model, ways, **manner), heard, background)


def test_features_are_pocketsphinxs(theirs, hello, tmp_path):
    """Where something sounds: both add other noise to digital silence, which counts for the mean of neither."""
    from pocketsphinx import Decoder

    sound = (np.pad(hello[0][:80000], 48000) * 20000).astype(np.int16)
    decoder = Decoder(lm=None, loglevel="FATAL", dither=True, seed=1, mfclogdir=str(tmp_path))
    decoder.add_fsg("one", decoder.create_fsg("one", 0, 1, [(0, 1, 1.0, "hello")]))
    decoder.activate_search("one")
    decoder.start_utt()
    decoder.process_raw(sound.tobytes(), full_utt=True)
    decoder.end_utt()
    data = next(tmp_path.iterdir()).read_bytes()
    order = "<" if len(data) == 4 * int.from_bytes(data[:4], "little") + 4 else ">"
    other = np.frombuffer(data[4:], f"{order}f4").reshape(-1, 13)
    other = other - other[other[:, 0] >= 0].mean(axis=0)
    mine = cepstra.features(sound)[:, :13]
    loud = mine[:, 0] > np.percentile(mine[:, 0], 80)
    assert np.abs(mine - other[: len(mine)])[loud].mean() < 0.5


def test_too_short_for_any_word(model):
    heard = model.hear(cepstra.features(np.ones(700, np.int16)), 1)
    ways = [[(model.phones["AH"],) * 9]]
    assert viterbi.best_path(model, graph.build_graph(model, ways), heard, np.zeros(len(heard.which))) == []
    assert not len(cepstra.features(np.zeros(100, np.int16)))


def test_both_engines_place_words_alike(hello, monkeypatch, theirs):
    sound, truth = hello
    stretch = align.Stretch([[word.lower()] for word, _, _ in truth])
    starts = {}
    for name in ("", "pocketsphinx"):
        monkeypatch.setenv(engines.ENVIRONMENT_VARIABLE, name)
        found = align.align_stretches(sound, [stretch])
        starts[name] = np.array([start for start, _ in found.spans])
        assert all(found.confidence) and not found.complaint
    true = np.array([start for _, start, _ in truth])
    ours, others = (np.abs(starts[name] - true).mean() for name in ("", "pocketsphinx"))
    print(f"mean error {1000 * ours:.1f} ms, pocketsphinx {1000 * others:.1f} ms")
    assert ours <= others + 0.005 and np.median(np.abs(starts["pocketsphinx"] - starts[""])) < 0.02


def test_which_engine(tmp_path, monkeypatch, theirs):
    monkeypatch.delenv(engines.ENVIRONMENT_VARIABLE, raising=False)
    assert isinstance(engines.create_engine({"hello"}, str(tmp_path)), numpy_engine.NumpyEngine)
    monkeypatch.setenv(engines.ENVIRONMENT_VARIABLE, "pocketsphinx")
    assert isinstance(engines.create_engine({"hello"}, str(tmp_path)), sphinx_engine.SphinxEngine)
    monkeypatch.delenv(engines.ENVIRONMENT_VARIABLE)
    assert engines.engine_name({"voice": "de"}) == "pocketsphinx" and engines.engine_name({"voice": None}) == ""
    monkeypatch.setenv(engines.ENVIRONMENT_VARIABLE, "numpy")
    assert engines.engine_name({"voice": "de"}) == ""
    monkeypatch.setenv(engines.ENVIRONMENT_VARIABLE, "pocketsphinx")
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    assert isinstance(engines.create_engine({"hello"}, str(tmp_path)), numpy_engine.NumpyEngine)


@pytest.mark.parametrize("damage", ["feat.params", "mdef", "sendump", "means", "transition_matrices"])
def test_models_of_another_kind_are_left_to_pocketsphinx(tmp_path, damage, monkeypatch, theirs):
    monkeypatch.delenv(engines.ENVIRONMENT_VARIABLE, raising=False)
    folder = tmp_path / "model"
    shutil.copytree(theirs / "en-us", folder)
    (folder / damage).write_bytes((folder / damage).read_bytes()[:60])
    with pytest.raises(sphinx_model.UnreadableModel):
        sphinx_model.read(folder)
    (tmp_path / "own.dict").write_text("hello HH AH L OW\n")
    own = {"acoustic": str(folder), "dictionary": str(tmp_path / "own.dict"), "letters": {}, "voice": None}
    assert isinstance(engines.create_engine({"hello"}, str(tmp_path), own), sphinx_engine.SphinxEngine)
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    with pytest.raises(EngineMissing, match="pocketsphinx"):
        language.load_language(tmp_path)


def test_pronunciations(tmp_path):
    (tmp_path / "own.dict").write_text("the DH AH\nthe(2)\tDH IY\nNATO N EY T OW\nempty\n")
    own = {"dictionary": tmp_path / "own.dict", "letters": None}
    words = lexicon.Lexicon({"the", "NATO", "The", "empty", "qwzx"}, own)
    assert words.ways("the") == ["DH AH", "DH IY"] and words.ways("The") == ["DH AH"]
    assert words.ways("NATO") == ["N EY T OW"] and words.ways("empty") and not words.ways("мир")


def test_a_head_that_goes_backwards_does_not_hang_its_reader(tmp_path):
    """A line of ``sendump`` whose length led back to itself was read for ever."""
    folder = sphinx_files.write(tmp_path / "model")
    sphinx_model.read(folder)
    weights = (folder / "sendump").read_bytes()
    (folder / "sendump").write_bytes(weights[:10] + (-4).to_bytes(4, "little", signed=True) + weights[14:])
    with pytest.raises(sphinx_model.UnreadableModel, match="no length"):
        sphinx_model.read(folder)


@pytest.mark.parametrize(("name", "place"), [("mdef", -8), ("mdef", 50), ("means", -4), ("transition_matrices", -4)])
def test_parts_that_do_not_fit_are_refused(tmp_path, name, place):
    folder = sphinx_files.write(tmp_path / "model")
    data = bytearray((folder / name).read_bytes())
    data[place : place + 4 or None] = b"\x7f\x7f\x7f\x7f"
    (folder / name).write_bytes(data)
    with pytest.raises(sphinx_model.UnreadableModel):
        sphinx_model.read(folder)


def test_a_dictionary_of_one_word_and_of_one_line_costs_little(tmp_path):
    (tmp_path / "own.dict").write_text("hello A B\n" * 100_000 + "there " + "A " * 500_000 + "\nof B\n")
    known = lexicon.Lexicon({"hello", "there", "of"}, {"dictionary": str(tmp_path / "own.dict")}).known()
    assert len(known["hello"]) == 16 and len(known["there"][0]) < 1000 and known["of"] == ["B"]
