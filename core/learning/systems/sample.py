"""A batch of windows with the inputs of all systems; each system uses some of them."""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import torch
from torch.nn import functional

from ...model.seeds import seed_input
from ...motion.skeleton import EDGES, MEAN

POSE = len(EDGES) * 3
PAD, START, END, UNKNOWN = range(4)
SPECIAL = 4
"""Number of special rows at the start of every word table (reference section A.4)."""


@dataclass(frozen=True)
class Sample:
    """Windows of T pose frames; lengths are given for the public code, where T is 34 (:mod:`lengths`).

    ``wave`` (B, 36267) at 16 kHz in -1..1; ``cepstra`` (B, 71, 14) MFCCs over 1000; ``words`` (B, T) row of the word table
    at each word's onset and 0 elsewhere; ``timing`` (B, T, 5) of :func:`word_timing.word_timing_features`; ``speaker`` (B,);
    ``directions`` (B, T, 9, 3) recorded unit vectors. The first ``seed_frames`` poses are given to the system.
    ``contextual`` (B, T, n) are contextual vectors of the current words, such as BERT's, if the user provides them.
    """

    wave: torch.Tensor
    cepstra: torch.Tensor
    words: torch.Tensor
    timing: torch.Tensor
    speaker: torch.Tensor
    directions: torch.Tensor
    seed_frames: int = 4
    contextual: torch.Tensor | None = None

    @cached_property
    def seeds(self) -> torch.Tensor:
        """Mean-subtracted seed poses with a mask ``(B, T, 28)``."""
        return seed_input(self.directions[:, : self.seed_frames], self.directions.shape[1])

    @cached_property
    def mfcc(self) -> torch.Tensor:
        """MFCC input ``(B, 37, 71)`` of the published network: coefficients and differences along the coefficients."""
        base = self.cepstra.transpose(1, 2)
        first = base[:, 1:].diff(dim=1)
        return torch.cat([base, first, first.diff(dim=1)], dim=1)

    @cached_property
    def poses(self) -> torch.Tensor:
        """Recorded, mean-subtracted directions ``(B, T, 27)``."""
        return (self.directions - torch.from_numpy(MEAN).to(self.directions)).flatten(2)

    def sequences(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Return word sequences ``(B, longest)`` from START to END, padded, and their lengths ``(B,)`` on the CPU."""
        is_onset = self.words != PAD
        lengths = is_onset.sum(1) + 2
        rows = self.words.new_full((len(self.words), int(lengths.max())), PAD)
        rows[:, 0] = START
        index = is_onset.long().cumsum(1)
        row, frame = is_onset.nonzero(as_tuple=True)
        rows[row, index[row, frame]] = self.words[row, frame]
        rows[torch.arange(len(rows), device=rows.device), lengths - 1] = END
        return rows, lengths.cpu()

    def to(self, device: str | torch.device) -> "Sample":
        """Return a copy on another device."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        tensors = {n: part.to(device, non_blocking=True) for n, part in parts.items() if isinstance(part, torch.Tensor)}
        return replace(self, **tensors)


class WordTable(torch.nn.Module):
    """Word vectors ``(rows, width)``, special rows first; frozen ones are not parameters and are not saved."""

    weight: torch.Tensor

    def __init__(self, vectors: torch.Tensor, trained: bool):
        super().__init__()
        if trained:
            self.weight = torch.nn.Parameter(vectors.clone())
        else:
            self.register_buffer("weight", vectors.clone(), persistent=False)

    def forward(self, words: torch.Tensor) -> torch.Tensor:
        """Return the vectors ``(..., width)`` of rows ``(...)``."""
        return functional.embedding(words, self.weight)


def word_vectors(vectors: torch.Tensor, trained: bool, seed: int = 0) -> torch.Tensor:
    """Build the rows of a word table from the data set's ``vectors`` ``(W, width)``.

    Special rows are random, as published; in a frozen table that of PAD is zero.
    """
    generator = torch.Generator().manual_seed(seed)
    special = torch.randn(SPECIAL, vectors.shape[1], generator=generator) * vectors.shape[1] ** -0.5
    if not trained:
        special[PAD] = 0
    return torch.cat([special, vectors.float().cpu()])
