"""The packed corpus: talks end to end, cut into random windows.

An ``.npz`` with, for all talks along time: ``directions`` (N, 9, 3) int8 (value * 127) or float16 at 15 fps, ``mfcc``
(M, 40) at 31.25 fps, ``word_index`` (N,) row of ``vectors`` (words, 300) or -1, ``starts`` and ``mfcc_starts``
(talks + 1,), ``speaker`` and ``split`` (talks,), and ``meta``, JSON text with "fps" and "speakers".
"""

import json
import zipfile
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np
import torch
from torch.nn import functional

from ..errors import CorpusUnreadable
from ..model.seeds import seed_input
from ..model.timing import mfcc_slice, nearest_mfcc
from ..skeleton import FPS, mirror
from .config import TrainConfig

TRAIN, VALIDATION, TEST = range(3)


@dataclass(frozen=True)
class Batch:
    """Windows on one device: what :class:`Generator` takes, and the performance it should give.

    ``mfcc`` (B, Ta, 40), ``words`` (B, T, 300), ``seeds`` (B, T, 28), ``directions`` (B, T, 9, 3), ``speaker`` (B,).
    """

    mfcc: torch.Tensor
    words: torch.Tensor
    seeds: torch.Tensor
    directions: torch.Tensor
    speaker: torch.Tensor


class Corpus:
    """Arrays of a packed corpus in memory; only the word vectors lie on ``device``, because batches repeat them."""

    def __init__(self, arrays: dict, device: str = "cpu"):
        self.meta = json.loads(str(arrays["meta"]))
        self.directions = np.asarray(arrays["directions"])
        self.mfcc = np.asarray(arrays["mfcc"])
        self.word_index = np.asarray(arrays["word_index"])
        self.starts, self.mfcc_starts, self.speaker, self.split = (
            np.asarray(arrays[name]).astype(np.int64) for name in ("starts", "mfcc_starts", "speaker", "split")
        )
        silent = np.zeros((1, arrays["vectors"].shape[1]), np.float32)
        self.vectors = torch.from_numpy(np.concatenate([arrays["vectors"], silent]).astype(np.float32)).to(device)
        self.device = device
        self._check()

    @classmethod
    def load(cls, path: str | PathLike, device: str = "cpu") -> "Corpus":
        """Read a packed corpus; raises :class:`CorpusUnreadable`."""
        try:
            with np.load(path) as data:
                return cls({name: data[name] for name in data.files}, device)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            message = f"{path} is not a packed corpus: {error}."
            raise CorpusUnreadable(message, "Build one with: python -m s2ag.core.corpus") from error

    @property
    def speakers(self) -> list[dict]:
        """Names and descriptions in the order of the speaker ids."""
        return self.meta["speakers"]

    def window_starts(self, split: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Talks of a split that hold a window of so many frames, and how many starts each offers."""
        room = np.maximum(np.diff(self.starts) - frames + 1, 0) * (self.split == split)
        talks = np.flatnonzero(room)
        if not len(talks):
            raise CorpusUnreadable(f"No talk of split {split} has {frames} frames.", "Use shorter windows or a larger corpus.")
        return talks, room[talks]

    def random_windows(self, rng: np.random.Generator, count: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Talk and first frame of training windows, every start equally likely."""
        talks, room = self.window_starts(TRAIN, frames)
        ends = np.cumsum(room)
        picked = rng.integers(ends[-1], size=count)
        row = np.searchsorted(ends, picked, side="right")
        return talks[row], picked - (ends - room)[row]

    def spread_windows(self, split: int, count: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """At most ``count`` windows of a split, evenly spread over its talks: the same ones at every call."""
        talks, room = self.window_starts(split, frames)
        ends = np.cumsum(room)
        picked = np.unique(np.linspace(0, ends[-1] - 1, count).astype(np.int64))
        row = np.searchsorted(ends, picked, side="right")
        return talks[row], picked - (ends - room)[row]

    def batch(
        self, talks: np.ndarray, first: np.ndarray, frames: int, seed_frames: int, flip: np.ndarray | None = None
    ) -> Batch:
        """Windows of ``frames`` that begin at frame ``first`` of ``talks``; those in ``flip`` are mirrored."""
        index = (self.starts[talks] + first)[:, None] + np.arange(frames)
        start = self.mfcc_starts[talks] + nearest_mfcc(first)
        heard = start[:, None] + np.arange(mfcc_slice(0, frames).stop)
        heard = np.minimum(heard, self.mfcc_starts[talks + 1][:, None] - 1)
        performed = self.directions[index].astype(np.float32)
        if flip is not None and flip.any():
            performed[flip] = mirror(performed[flip])
        directions = functional.normalize(torch.from_numpy(performed).to(self.device), dim=-1)
        return Batch(
            mfcc=torch.from_numpy(self.mfcc[heard].astype(np.float32)).to(self.device),
            words=functional.embedding(
                torch.from_numpy(self.word_index[index].astype(np.int64)).to(self.device) % len(self.vectors), self.vectors
            ),
            seeds=seed_input(directions[:, :seed_frames], frames),
            directions=directions,
            speaker=torch.from_numpy(self.speaker[talks]).to(self.device),
        )

    def _check(self) -> None:
        frames, heard = len(self.directions), len(self.mfcc)
        talks = len(self.speaker)
        if not (
            self.directions.shape[1:] == (9, 3)
            and len(self.word_index) == frames == self.starts[-1]
            and heard == self.mfcc_starts[-1]
            and len(self.starts) == len(self.mfcc_starts) == talks + 1 == len(self.split) + 1
            and self.speaker.max() < len(self.speakers)
            and self.word_index.min() >= -1
            and self.word_index.max() < len(self.vectors) - 1
        ):
            raise ValueError("its arrays do not fit each other")
        if self.meta.get("fps", FPS) != FPS:
            raise ValueError(f"it runs at {self.meta['fps']} fps, not {FPS}")


def augment(batch: Batch, config: TrainConfig) -> Batch:
    """Drop words and seeds of whole windows and disturb MFCCs and seeds, from torch's own random numbers."""
    count, device = len(batch.speaker), batch.mfcc.device

    def kept(chance: float) -> torch.Tensor:
        return (torch.rand(count, 1, 1, device=device) >= chance).float()

    mfcc = batch.mfcc + config.mfcc_noise * torch.randn_like(batch.mfcc)
    mfcc[..., 0] += config.mfcc_gain * torch.randn(count, 1, device=device)
    poses, mask = batch.seeds[..., :-1], batch.seeds[..., -1:]
    poses = poses + config.seed_noise * torch.randn_like(poses) * mask
    seeds = torch.cat([poses, mask], dim=-1) * kept(config.seed_drop)
    return replace(batch, mfcc=mfcc, words=batch.words * kept(config.word_drop), seeds=seeds)
