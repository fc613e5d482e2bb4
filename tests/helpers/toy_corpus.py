"""A tiny corpus whose arms rise with the voice's energy: enough to see whether a network can learn to follow a voice."""

import numpy as np
from s2ag.core.learning.train.storage import save_arrays
from s2ag.core.model.mfcc_timing import nearest_mfcc
from s2ag.core.motion.skeleton import MEAN_UNIT, normalize
from s2ag.core.styles import CONTROLS

SPEAKERS = 2
PROSODY = 4
META = {"format": 2, "fps": 15, "speakers": [{"name": "small"}, {"name": "large"}], "mfcc": "toy", "meanings": ["a", "b"]}


def toy_arrays(talks: int = 6, frames: int = 200, seed: int = 0) -> dict:
    """Arrays of a packed corpus: two performances of every recording, by speakers who differ in reach.

    The last recording is the validation split. Arousal widens the gestures of every second pair of performances.
    """
    rng = np.random.default_rng(seed)
    recordings, heard = (talks + 1) // 2, int(nearest_mfcc(frames)) + 1
    mfcc = rng.normal(0, 0.3, (recordings, heard, 40))
    time = np.arange(heard) / 31.25
    phase = rng.uniform(0, 2 * np.pi, (2, recordings, 1))
    mfcc[..., 0] = np.sin(2 * np.pi * 0.7 * time + phase[0]) + 0.5 * np.sin(2 * np.pi * 1.3 * time + phase[1])
    energy = mfcc[:, np.minimum(nearest_mfcc(np.arange(frames)), heard - 1), 0]
    prosody = np.stack([energy, np.abs(energy), *rng.normal(0, 1, (PROSODY - 2, *energy.shape))], -1)
    recording, speaker = np.arange(talks) // 2, np.arange(talks) % SPEAKERS
    controls = np.zeros((talks, len(CONTROLS)), np.float32)
    controls[recording % 2 == 1, CONTROLS.index("arousal")] = 0.5
    reach = np.where(speaker, 0.8, 0.4) * (1 + controls[:, 0])
    directions = np.broadcast_to(MEAN_UNIT, (talks, frames, 9, 3)).copy()
    directions[:, :, [4, 5, 7, 8], 1] -= 0.5 * (energy[recording] * reach[:, None])[..., None]
    return {
        "mfcc": mfcc.reshape(-1, 40).astype(np.float16),
        "mfcc_starts": np.arange(recordings + 1) * heard,
        "frame_starts": np.arange(recordings + 1) * frames,
        "word_index": rng.integers(-1, 5, recordings * frames // 10).repeat(10).astype(np.int32),
        "vectors": rng.normal(0, 0.06, (5, 300)).astype(np.float16),
        "prosody": prosody.reshape(-1, PROSODY).astype(np.float16),
        "prosody_plain": (prosody.reshape(-1, PROSODY) + 3).astype(np.float16),
        "directions": normalize(directions).reshape(-1, 9, 3).astype(np.float16),
        "starts": np.arange(talks + 1) * frames,
        "recording": recording,
        "speaker": speaker,
        "split": (recording == recordings - 1).astype(int),
        "controls": controls,
        "strokes": np.stack(np.broadcast_arrays(np.arange(talks), 1.0, 2.0, 3.0, np.arange(talks) % 2, 1, 0.5), 1).astype(
            np.float32
        ),
    }


def write_toy_corpus(folder, **settings):
    """Write the corpus to ``folder`` and return it."""
    return save_arrays(folder, toy_arrays(**settings), META)
