"""The bench's windows: what they hold, which are left out, what is cached, and data that are refused."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.bench.data import Data  # noqa: E402
from s2ag.core.learning.bench.resident import Resident  # noqa: E402
from s2ag.core.learning.train.storage import save_arrays  # noqa: E402
from toy_bench import bench_arrays, write_bench_corpus  # noqa: E402
from toy_corpus import write_toy_corpus  # noqa: E402


def test_windows_hold_what_was_heard_and_performed(data, corpus):
    arrays, meta = bench_arrays()
    window = data.windows[0][7]
    sample = data.sample(window[None])
    talk, first = window
    rows = arrays["starts"][talk] + first + np.arange(34)
    np.testing.assert_allclose(sample.directions[0], arrays["directions"][rows], atol=2e-3)
    begin = arrays["wave_starts"][arrays["recording"][talk]] + round(first * 16000 / 15)
    np.testing.assert_allclose(sample.wave[0] * 32768, arrays["wave"][begin : begin + 36267])
    words = [w for w in meta["recordings"][arrays["recording"][talk]]["words"] if first / 15 <= w[1] < (first + 34) / 15]
    for word, start, _ in words:
        assert sample.words[0, round(start * 15) - first] == meta["words"].index(word) + 4
    assert set(data.corpus.split[data.windows[2][:, 0]]) == {2}


@pytest.mark.parametrize("window", [34, 60])
def test_a_gpu_gathers_the_same_windows(corpus, tmp_path, window):
    """Tried on a CPU: the arrays lie in torch, and nothing of a batch goes through numpy."""
    data = Data(corpus, tmp_path, filtered=False, window=window)
    windows = np.concatenate([data.spread(0, 40), data.spread(2, 10)])
    windows[0] = 0, 180  # beyond its recording's sound
    ours, theirs = data.sample(windows), Resident(data, "cpu").sample(windows)
    for name in ("wave", "cepstra", "words", "timing", "speaker", "directions", "seeds", "mfcc"):
        one, other = getattr(ours, name), getattr(theirs, name)
        assert one.dtype == other.dtype and one.shape == other.shape, name
        torch.testing.assert_close(one, other, rtol=0, atol=1e-6)


def test_a_word_under_way_counts_in_the_first_frame(data):
    arrays, _ = bench_arrays()
    for window in data.windows[0][:40]:
        row = arrays["frame_starts"][arrays["recording"][window[0]]] + window[1]
        heard = int(data.sample(window[None]).words[0, 0])
        assert heard == (arrays["word_index"][row] + 4 if arrays["word_index"][row] >= 0 else 0)


def test_sound_ends_in_silence(data):
    last = data.windows[0][data.windows[0][:, 0] == 0][-1:].copy()
    last[0, 1] = 180
    assert not data.sounds(last)[0, -8000:].any() and data.sounds(last)[0, :8000].any()


def test_features_are_cached_and_made_again_for_other_data(corpus, tmp_path):
    Data(corpus, tmp_path, filtered=False)
    stamp = (tmp_path / "features" / "timing.npy").stat().st_mtime_ns
    Data(corpus, tmp_path, filtered=False)
    assert (tmp_path / "features" / "timing.npy").stat().st_mtime_ns == stamp
    other = write_bench_corpus(tmp_path / "other", seed=5)
    Data(other, tmp_path, filtered=False)
    assert (tmp_path / "features" / "timing.npy").stat().st_mtime_ns != stamp


def test_filters_drop_what_does_not_move(tmp_path):
    arrays, meta = bench_arrays()
    arrays["directions"] = arrays["directions"].copy()
    arrays["directions"][arrays["starts"][0] : arrays["starts"][1]] = arrays["directions"][0]
    data = Data(save_arrays(tmp_path / "c", arrays, meta), tmp_path)
    assert 0 not in data.windows[0][:, 0] and len(data.windows[0])


def test_data_without_sound_or_words_is_refused(tmp_path):
    with pytest.raises(CorpusUnreadable, match="holds no sound"):
        Data(write_toy_corpus(tmp_path / "toy"), tmp_path)
    arrays, meta = bench_arrays()
    meta.pop("recordings")
    with pytest.raises(CorpusUnreadable, match="does not list the words"):
        Data(save_arrays(tmp_path / "c", arrays, meta), tmp_path)
    arrays, meta = bench_arrays()
    arrays["wave"] = arrays["wave"][:-5]
    with pytest.raises(CorpusUnreadable, match="does not fit"):
        Data(save_arrays(tmp_path / "d", arrays, meta), tmp_path)
