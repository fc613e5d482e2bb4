import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.errors import VectorsUnreadable
from s2ag.core.vectors import build, table
from s2ag.core.vectors.table import WordVectors


@pytest.fixture(scope="module")
def vectors():
    return WordVectors.load()


def cosine(a, b):
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def test_the_shipped_file_is_small_and_complete(vectors):
    assert table.SHIPPED.stat().st_size <= 15 * 2**20
    assert len(vectors) == 50_000
    assert all(word in vectors for word in ("the", "I", "you", "not", "big", "here", "don't", "gesture"))
    assert table.SHIPPED.with_name("NOTICE.txt").is_file()


def test_lookup_needs_no_gensim():
    load = "from s2ag.core.vectors.table import WordVectors as W; W.load().vector('zzyx')"
    program = f"import sys; {load}; print('gensim' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "False\n"


def test_vectors_are_close_to_what_they_were_packed_from(vectors, shared):
    with np.load(shared / "embedding" / "words.npz") as source:
        names = str(source["words"]).split("\n")[::97]
        original = (source["q"] * source["s"].astype(np.float32)[:, None])[::97]
    packed = vectors.vectors(names)
    cosines = np.einsum("ij,ij->i", packed, original) / np.linalg.norm(packed, axis=1) / np.linalg.norm(original, axis=1)
    assert cosines.mean() > 0.98 and cosines.min() > 0.95


def test_neighbours_make_sense(vectors):
    names = list(vectors.key_to_index)
    every = vectors.vectors(names)
    for word, near in (("happy", {"happier", "thrilled"}), ("BIG", {"huge", "bigger"})):
        nearest = np.argsort(-every @ vectors.vector(word) / np.maximum(np.linalg.norm(every, axis=1), 1e-9))[:9]
        assert near <= {names[number] for number in nearest}
    assert cosine(vectors.vector("happyish"), vectors.vector("happy")) > 0.5


@pytest.mark.parametrize(
    ("one", "other"),
    [("Happy", "happy"), ("DON’T", "don't"), ("“here!”", "here"), ("Café", "cafe"), ("zebra's", "zebra"), ("2", "two")],
)
def test_spelling_does_not_matter(vectors, one, other):
    np.testing.assert_array_equal(vectors.vector(one), vectors.vector(other))


def test_unknown_words(vectors):
    assert "happyish" not in vectors
    assert np.linalg.norm(vectors.vector("happyish")) > 0.1
    np.testing.assert_allclose(
        vectors.vector("zebra-piano"), (vectors.vector("zebra") + vectors.vector("piano")) / 2, atol=1e-6
    )
    for nothing in ("", "—", "...", "[]"):
        assert not vectors.vector(nothing).any()


def test_vectors_are_shared_and_read_only(vectors):
    assert vectors.vector("hello") is vectors.vector("hello")
    with pytest.raises(ValueError):
        vectors.vector("hello")[0] = 1
    assert vectors.vectors([]).shape == (0, 300)


@pytest.mark.parametrize("word", ["hello", "naïve", "é", "a", "日本語です", "I'm", "straße", "x" * 40])
@pytest.mark.parametrize(("low", "high"), [(3, 6), (1, 4)])
def test_ngram_hashes_equal_gensims(word, low, high):
    fasttext = pytest.importorskip("gensim.models.fasttext", reason="gensim is not installed")
    assert table.ngram_hashes(word, low, high, 50_000) == list(fasttext.ft_ngram_hashes(word, low, high, 50_000))


def test_packing_restores_rows_and_repeats_itself():
    rng = np.random.default_rng(0)
    rows = (rng.normal(size=(600, 300)) * np.linspace(2, 0.2, 300)).astype(np.float32)
    packed = build.quantise(rows, np.random.default_rng(1))
    again = build.quantise(rows, np.random.default_rng(1))
    assert all(np.array_equal(packed[key], again[key]) for key in packed)
    restored = table.decode(packed, np.arange(600))
    error = np.linalg.norm(restored - rows) / np.linalg.norm(rows)
    assert error < 0.25
    np.testing.assert_array_equal(table.decode(packed, np.array([5, 3])), restored[[5, 3]])


def test_the_axes_are_dealt_evenly():
    variance = np.geomspace(1, 1e-3, 300)
    order = build.balanced_order(variance)
    assert sorted(order) == list(range(300))
    products = np.log(variance[order.reshape(100, 3)]).sum(1)
    assert np.ptp(products) < 0.15 * np.ptp(np.log(variance.reshape(100, 3)).sum(1))


@pytest.fixture(scope="module")
def own():
    """Three words as gensim holds them."""
    gensim = pytest.importorskip("gensim.models", reason="gensim is not installed")
    keyed = gensim.KeyedVectors(300)
    keyed.add_vectors(["so", "Here", "big"], np.random.default_rng(0).normal(size=(3, 300)).astype(np.float32))
    return keyed


@pytest.mark.parametrize("suffix", [".vec", ".bin"])
def test_own_vectors(own, tmp_path, suffix):
    path = tmp_path / f"mine{suffix}"
    own.save_word2vec_format(str(path), binary=suffix == ".bin")
    loaded = WordVectors.load(path)
    assert list(loaded.key_to_index) == ["so", "Here", "big"]
    np.testing.assert_allclose(loaded.vector("SO"), own["so"], atol=1e-6)
    np.testing.assert_allclose(loaded.vector("Here"), own["Here"], atol=1e-6)
    assert not loaded.vector("unknown").any()


class Trap:
    """What runs when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


@pytest.mark.parametrize("name", ["mine.kv", "mine.bin", "mine.vec", "mine.npz"])
def test_no_pickle_is_ever_run(tmp_path, name):
    (tmp_path / name).write_bytes(pickle.dumps(Trap(tmp_path / "trace")))
    with pytest.raises(VectorsUnreadable):
        WordVectors.load(tmp_path / name)
    assert not (tmp_path / "trace").exists()


@pytest.mark.parametrize("head", ["999999999 300", "3 999999999", "-1 300", "x"])
def test_a_first_line_that_promises_too_much_costs_nothing(tmp_path, head):
    pytest.importorskip("gensim", reason="gensim is not installed")
    for name in ("mine.bin", "mine.vec"):
        (tmp_path / name).write_bytes(head.encode() + b"\nword 0.5\n")
        with pytest.raises(VectorsUnreadable, match="cannot be read"):
            WordVectors.load(tmp_path / name)


def gensim_sample(name):
    return Path(pytest.importorskip("gensim", reason="gensim is not installed").__file__).parent / "test" / "test_data" / name


def test_fasttext_of_five_dimensions_is_refused():
    path = gensim_sample("crime-and-punishment.bin")
    if not path.is_file():
        pytest.skip("this gensim ships no test data")
    with pytest.raises(VectorsUnreadable, match="5-dimensional vectors; the network reads 300"):
        WordVectors.load(path)


def test_fasttext_files_know_unknown_words(tmp_path):
    fasttext = pytest.importorskip("gensim.models.fasttext", reason="gensim is not installed")
    sentences = [["here", "we", "go", "again"], ["big", "hands", "go", "here"]]
    model = fasttext.FastText(sentences, vector_size=300, min_count=1, bucket=500, epochs=1, seed=1, workers=1)
    path = tmp_path / "small.bin"
    fasttext.save_facebook_model(model, str(path))
    loaded = WordVectors.load(path)
    np.testing.assert_allclose(loaded.vector("hands"), model.wv["hands"], atol=1e-6)
    np.testing.assert_allclose(loaded.vector("handsome"), model.wv["handsome"], atol=1e-6)
    assert loaded.vector("handsome").any()


@pytest.mark.parametrize("name", ["missing.npz", "damaged.npz", "damaged.bin", "damaged.kv", "damaged.vec", "what.dat"])
def test_unreadable_vectors_say_so(tmp_path, name):
    if not name.endswith((".npz", ".dat")):
        pytest.importorskip("gensim", reason="gensim is not installed")
    if not name.startswith("missing"):
        (tmp_path / name).write_bytes(b"\x00\x01 damaged \xff" * 9)
    with pytest.raises(VectorsUnreadable) as caught:
        WordVectors.load(tmp_path / name)
    assert caught.value.message.endswith(".") and caught.value.remedy.endswith((".", "py", '"'))


def test_gensim_missing_has_a_remedy(tmp_path):
    (tmp_path / "mine.vec").write_text("1 300\n")
    program = (
        "import sys; sys.modules['gensim'] = None\n"
        "from s2ag.core.vectors.table import WordVectors\nfrom s2ag.core.errors import VectorsUnreadable\n"
        "try: WordVectors.load(sys.argv[1])\nexcept VectorsUnreadable as error: print(error)"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "mine.vec")]
    assert "pip install" in subprocess.run(command, capture_output=True, text=True, check=True).stdout


SAID = (("so", -0.2, 0.1), ("over", -0.5, -0.1), ("big", 0.3, 0.5), ("here", 0.52, 0.56), ("hands", 0.9, 3.0))


def test_words_lie_on_the_frames_of_their_span():
    index = table.word_per_frame(SAID, 20)
    assert index.tolist() == [0, 0] + [-1] * 2 + [2] * 3 + [3] * 2 + [-1] * 4 + [4] * 7


def test_onsets_take_one_frame():
    index = table.word_per_frame(SAID, 20, mode="onset")
    assert [(frame, int(index[frame])) for frame in np.flatnonzero(index >= 0)] == [(0, 0), (4, 2), (7, 3), (13, 4)]


def test_a_window_in_the_middle_of_a_word():
    assert table.word_per_frame(SAID, 4, start=1.5).tolist() == [4] * 4
    assert table.word_per_frame(SAID, 4, start=1.5, mode="onset").tolist() == [4, -1, -1, -1]
    assert table.word_per_frame(SAID, 4, start=3.0).tolist() == [-1] * 4


def test_every_window_sees_what_the_whole_sees():
    whole = table.word_per_frame(SAID, 60)
    for first in range(0, 50, 7):
        np.testing.assert_array_equal(table.word_per_frame(SAID, 10, start=first / 15), whole[first : first + 10])


def test_place(vectors):
    placed = table.vectors_per_frame(SAID, vectors, 20)
    assert placed.shape == (20, 300) and placed.dtype == np.float32
    np.testing.assert_array_equal(placed[5], vectors.vector("big"))
    assert not placed[3].any()
    assert not table.vectors_per_frame((), vectors, 4).any()
    with pytest.raises(ValueError, match="mode"):
        table.vectors_per_frame(SAID, vectors, 4, mode="middle")


@pytest.mark.parametrize("name", ["word_order", "word_norms", "ngram_centroids"])
def test_tables_with_missing_axes_or_no_numbers_are_refused(tmp_path, name):
    with np.load(Path(table.__file__).parents[1] / "assets" / "words.npz") as held:
        arrays = {key: held[key] for key in held.files}
    arrays[name] = np.zeros_like(arrays[name]) if name == "word_order" else np.full_like(arrays[name], np.nan)
    np.savez(tmp_path / "own.npz", **arrays)
    with pytest.raises(VectorsUnreadable, match="holds no packed word vectors"):
        WordVectors.load(tmp_path / "own.npz")
