"""A tiny corpus whose arms rise with the voice's energy: enough to see whether a network can learn to follow a voice."""

import json

import numpy as np
from s2ag.core.model.timing import nearest_mfcc
from s2ag.core.skeleton import MEAN_UNIT, normalize

SPEAKERS = 2


def toy_arrays(talks: int = 6, frames: int = 200, seed: int = 0) -> dict:
    """Arrays of a packed corpus; the last talk is the validation split, speakers take turns and differ in reach."""
    rng = np.random.default_rng(seed)
    heard = int(nearest_mfcc(frames)) + 1
    mfcc = rng.normal(0, 0.3, (talks, heard, 40))
    time = np.arange(heard) / 31.25
    phase = rng.uniform(0, 2 * np.pi, (2, talks, 1))
    mfcc[..., 0] = np.sin(2 * np.pi * 0.7 * time + phase[0]) + 0.5 * np.sin(2 * np.pi * 1.3 * time + phase[1])
    speaker = np.arange(talks) % SPEAKERS
    energy = mfcc[:, np.minimum(nearest_mfcc(np.arange(frames)), heard - 1), 0] * np.where(speaker, 0.8, 0.4)[:, None]
    directions = np.broadcast_to(MEAN_UNIT, (talks, frames, 9, 3)).copy()
    for edge in (4, 5, 7, 8):
        directions[:, :, edge, 1] -= 0.5 * energy
    spoken = rng.integers(-1, 5, talks * frames // 10).repeat(10)
    return {
        "directions": normalize(directions).reshape(-1, 9, 3).astype(np.float16),
        "mfcc": mfcc.reshape(-1, 40).astype(np.float16),
        "word_index": spoken.astype(np.int32),
        "vectors": rng.normal(0, 0.06, (5, 300)).astype(np.float16),
        "starts": np.arange(talks + 1) * frames,
        "mfcc_starts": np.arange(talks + 1) * heard,
        "speaker": speaker,
        "split": (np.arange(talks) == talks - 1).astype(int),
        "meta": np.array(json.dumps({"fps": 15, "speakers": [{"name": "small"}, {"name": "large"}], "mfcc": "toy"})),
    }


def write_toy_corpus(path, **settings):
    """Write the corpus to ``path`` (.npz) and return the path."""
    np.savez(path, **toy_arrays(**settings))
    return path
