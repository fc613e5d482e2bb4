"""Training: windows a second of a full adversarial step, and of gathering batches against one window after the other.

Run: pytest tests/benchmarks/test_train.py --benchmark-only
"""

import timeit

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("pytest_benchmark")

from s2ag.core.learning.train.adversarial import Adversarial  # noqa: E402
from s2ag.core.learning.train.config import TrainConfig  # noqa: E402
from s2ag.core.learning.train.dataset import Corpus, draw_windows  # noqa: E402
from s2ag.core.learning.train.process import launch  # noqa: E402
from s2ag.core.model.mfcc_timing import mfcc_slice  # noqa: E402
from s2ag.core.model.seeds import seed_input  # noqa: E402
from toy_corpus import PROSODY, write_toy_corpus  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two hours of performances, shorter than a real corpus but gathered in the same way."""
    return write_toy_corpus(tmp_path_factory.mktemp("corpus") / "corpus", talks=120, frames=900)


def settings(**changes):
    return TrainConfig.from_dict({"model_settings": {"prosody_features": PROSODY}, "threads": 1, **changes})


def report(benchmark, windows):
    rate = windows / benchmark.stats.stats.median
    benchmark.extra_info["windows_per_second"] = round(rate, 1)
    return rate


@pytest.mark.parametrize("precision", ["32-true", "bf16-mixed"])
def test_adversarial_step(benchmark, folder, precision):
    config = settings(precision=precision)
    trainer = Adversarial(config, Corpus.load(folder), launch(config))
    trainer.setup()
    trainer.step()
    trainer.outside_seconds = 0.0
    benchmark.pedantic(trainer.step, rounds=10, warmup_rounds=0)
    trainer.close()
    rate = report(benchmark, config.batch)
    benchmark.extra_info["frames_per_second"] = round(rate * config.frames)
    benchmark.extra_info["outside"] = round(trainer.outside_seconds / benchmark.stats.stats.total, 4)
    print(
        f"\n{precision}, one thread: {rate:.1f} windows ({rate * config.frames:,.0f} pose frames) a second, "
        f"{benchmark.extra_info['outside']:.1%} of the time outside the networks"
    )


def test_batches_against_window_by_window(benchmark, folder):
    config = settings()
    corpus = Corpus.load(folder)
    windows = draw_windows(corpus, config, np.random.default_rng(0))
    benchmark.pedantic(corpus.batch, args=(windows, config.frames, config.seed_frames), rounds=20, warmup_rounds=1)
    rate = report(benchmark, config.batch)
    singly = min(timeit.repeat(lambda: one_by_one(corpus, windows, config), number=1, repeat=10))
    benchmark.extra_info["ratio"] = singly / benchmark.stats.stats.min
    print(f"\nbatches: {rate:,.0f} windows a second, {benchmark.extra_info['ratio']:.1f} times as fast as one after the other")


def one_by_one(corpus, windows, config):
    """The way of data sets that return one window: slices, a lookup for every word, and tensors stacked in the end."""
    items = []
    for talk, first in zip(windows.talk, windows.first, strict=True):
        recording = corpus.recording[talk]
        spoken, heard = corpus.frame_starts[recording] + first, mfcc_slice(first, first + config.frames)
        mfcc = corpus.mfcc[corpus.mfcc_starts[recording] + heard.start :][: heard.stop - heard.start]
        rows = corpus.word_index[spoken : spoken + config.frames]
        words = np.stack([corpus.vectors[row].numpy() if row >= 0 else np.zeros(300, np.float32) for row in rows])
        poses = corpus.directions[corpus.starts[talk] + first :][: config.frames].astype(np.float32)
        poses = torch.from_numpy(poses / np.linalg.norm(poses, axis=-1, keepdims=True))
        prosody = corpus.prosody[spoken : spoken + config.frames].astype(np.float32)
        seeds = seed_input(poses[None, : config.seed_frames], config.frames)[0]
        items.append((*map(torch.from_numpy, (mfcc.astype(np.float32), words, prosody)), poses, seeds))
    return [torch.stack(part) for part in zip(*items, strict=True)]
