"""The toy corpus with sound, words and a test split: enough for every system of the bench."""

import numpy as np
import torch
from s2ag.core.learning.bench.data import Data
from s2ag.core.learning.bench.evaluation import Bench
from s2ag.core.learning.metrics.extractor import Extractor
from s2ag.core.learning.train.storage import save_arrays
from s2ag.core.sound.prosody import FEATURES
from toy_corpus import META, toy_arrays


def bench_arrays(talks=12, frames=200, seed=0):
    """Arrays and meta; the sound's loudness follows the arms, the last two recordings are validation and test."""
    arrays = toy_arrays(talks, frames, seed)
    rng = np.random.default_rng(seed)
    for name in ("prosody", "prosody_plain"):
        arrays[name] = np.pad(arrays[name], ((0, 0), (0, FEATURES - arrays[name].shape[1])))
    recordings = (talks + 1) // 2
    energy = arrays["prosody"][:, 1].astype(float).repeat(16000 // 15 + 1)
    samples = int(frames / 15 * 16000)
    wave = rng.normal(0, 1, (recordings, samples)) * np.resize(energy, (recordings, samples))
    arrays["wave"] = np.clip(wave * 3000, -32767, 32767).astype(np.int16).reshape(-1)
    arrays["wave_starts"] = np.arange(recordings + 1) * samples
    arrays["split"] = np.maximum(arrays["recording"] - (recordings - 3), 0).astype(int)
    words = arrays["word_index"].reshape(recordings, -1)
    vocabulary = ["one", "beautiful", "day", "of", "gestures"]
    known = []
    for row in words:
        edges = np.flatnonzero(np.diff(row, prepend=-2, append=-2))
        spans = [(int(row[a]), a / 15, b / 15) for a, b in zip(edges, edges[1:], strict=False) if row[a] >= 0]
        known.append({"words": [[vocabulary[i], a, b] for i, a, b in spans]})
    return arrays, {**META, "words": vocabulary, "recordings": known}


def write_bench_corpus(folder, **settings):
    """Write it to ``folder`` and return it."""
    return save_arrays(folder, *bench_arrays(**settings))


def write_tested_corpus(folder, seed=0, **facts):
    """Write one of which three recordings are for testing, each performed by both speakers, with these ``facts``."""
    arrays, meta = bench_arrays(talks=14, seed=seed)
    arrays["split"] = np.array([0, 0, 0, 1, 2, 2, 2])[arrays["recording"]]
    return save_arrays(folder, arrays, {**meta, **facts})


def bench_of(corpus, cache, windows):
    """A bench of so many windows on a corpus, with an extractor of random weights."""
    torch.manual_seed(0)
    return Bench(Data(corpus, cache, filtered=False), Extractor().eval(), windows)
