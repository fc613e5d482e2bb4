"""A data set that lies on a GPU as a whole, where the windows of a batch are gathered without the CPU."""

from typing import TYPE_CHECKING

import numpy as np
import torch

from ...model.mfcc_timing import nearest_mfcc
from ...motion.skeleton import normalize
from ...sound.audio import SAMPLE_RATE
from ..systems.sample import PAD, SPECIAL, Sample

if TYPE_CHECKING:
    from .data import Data


class Resident:
    """The arrays of ``data`` on a ``device``; :meth:`sample` returns what :meth:`Data.sample` returns, made there."""

    def __init__(self, data: "Data", device: str):
        self.device, self.given, self.lengths, corpus = device, data.given, data.lengths, data.corpus
        self.contextual = data.contextual
        self.wave, self.wave_starts = self._put(data.wave), self._put(data.wave_starts)
        self.cepstra, self.mfcc_starts = self._put(data.cepstra), self._put(corpus.mfcc_starts)
        self.onsets, self.timing = self._put(data.onsets), self._put(data.timing)
        self.under_way, self.frame_starts = self._put(corpus.word_index), self._put(corpus.frame_starts)
        self.directions = self._put(normalize(corpus.directions.astype(np.float32)))
        self.starts, self.recording, self.speaker = map(self._put, (corpus.starts, corpus.recording, corpus.speaker))

    def sample(self, windows: np.ndarray) -> Sample:
        """Return windows ``(n, 2)`` with the inputs of all systems."""
        talk, first = self._put(windows).T
        recording, lengths = self.recording[talk], self.lengths
        frames = (self.frame_starts[recording] + first)[:, None] + self._range(lengths.frames)
        poses = (self.starts[talk] + first)[:, None] + self._range(lengths.frames)
        rows = (self.mfcc_starts[recording] + nearest_mfcc(first, lengths.fps))[:, None] + self._range(lengths.cepstra)
        words = self.onsets[frames].long()
        under_way = self.under_way[frames[:, 0]].long() + SPECIAL
        words[:, 0] = torch.where((words[:, 0] == PAD) & (under_way >= SPECIAL), under_way, words[:, 0])
        contextual = None
        if self.contextual is not None:
            contextual = torch.from_numpy(self.contextual.of(frames.cpu().numpy())).to(self.device)
        return Sample(
            wave=self._sounds(recording, first),
            cepstra=self.cepstra[torch.minimum(rows, self.mfcc_starts[recording + 1][:, None] - 1)].float(),
            words=words,
            timing=self.timing[frames].float(),
            speaker=self.speaker[talk],
            directions=self.directions[poses],
            seed_frames=self.given,
            contextual=contextual,
        )

    def _sounds(self, recording: torch.Tensor, first: torch.Tensor) -> torch.Tensor:
        """Return the samples of windows in -1..1, with silence beyond a recording's end."""
        begin = self.wave_starts[recording] + (first.double() * (SAMPLE_RATE / self.lengths.fps)).round().long()
        rows, end = begin[:, None] + self._range(self.lengths.samples), self.wave_starts[recording + 1][:, None]
        return self.wave[rows.clamp(max=len(self.wave) - 1)].float() / 32768 * (rows < end)

    def _range(self, count: int) -> torch.Tensor:
        return torch.arange(count, device=self.device)

    def _put(self, array: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(np.array(array)).to(self.device)
