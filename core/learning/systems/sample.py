"""A batch of windows as every system takes it; what a system does not hear it leaves alone."""

from dataclasses import dataclass, fields
from functools import cached_property

import torch
from torch.nn import functional

from ...model.seeds import seed_input
from ...motion.skeleton import EDGES, MEAN

POSE = len(EDGES) * 3
PAD, START, END, UNKNOWN = range(4)
SPECIAL = 4
"""Rows of every word table before the vocabulary's own (reference section A.4)."""


@dataclass(frozen=True)
class Sample:
    """Windows of T pose frames; lengths are those of the public codes, T being 34 (:mod:`lengths`).

    ``wave`` (B, 36267) at 16 kHz in -1..1; ``cepstra`` (B, 71, 14) MFCCs over 1000; ``words`` (B, T) row of the word table
    at each word's onset and 0 elsewhere; ``timing`` (B, T, 5) of :func:`timing.describe`; ``speaker`` (B,);
    ``directions`` (B, T, 9, 3) as performed, unit vectors. The first ``seed_frames`` poses are given to the system.
    ``contextual`` (B, T, n) are vectors of the words under way in their context, such as BERT's, where the user brought any.
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
        """Given poses less the mean with a mask ``(B, T, 28)``."""
        return seed_input(self.directions[:, : self.seed_frames], self.directions.shape[1])

    @cached_property
    def mfcc(self) -> torch.Tensor:
        """``(B, 37, 71)`` of the published network: coefficients and differences along the coefficients."""
        base = self.cepstra.transpose(1, 2)
        first = base[:, 1:].diff(dim=1)
        return torch.cat([base, first, first.diff(dim=1)], dim=1)

    @cached_property
    def poses(self) -> torch.Tensor:
        """Performed directions less the mean ``(B, T, 27)``."""
        return (self.directions - torch.from_numpy(MEAN).to(self.directions)).flatten(2)

    def sequences(self) -> tuple[torch.Tensor, torch.Tensor]:
        """The words alone ``(B, longest)`` between START and END, padded, and their lengths ``(B,)`` on the CPU."""
        heard = self.words != PAD
        lengths = heard.sum(1) + 2
        rows = self.words.new_full((len(self.words), int(lengths.max())), PAD)
        rows[:, 0] = START
        place = heard.long().cumsum(1)
        row, frame = heard.nonzero(as_tuple=True)
        rows[row, place[row, frame]] = self.words[row, frame]
        rows[torch.arange(len(rows), device=rows.device), lengths - 1] = END
        return rows, lengths.cpu()

    def to(self, device) -> "Sample":
        """The same on another device."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        tensors = {n: part.to(device, non_blocking=True) for n, part in parts.items() if isinstance(part, torch.Tensor)}
        return Sample(**(parts | tensors))


class WordTable(torch.nn.Module):
    """Vectors of words, special rows first, ``(rows, width)``; frozen ones are no parameters and are not saved."""

    def __init__(self, vectors: torch.Tensor, trained: bool):
        super().__init__()
        if trained:
            self.weight = torch.nn.Parameter(vectors.clone())
        else:
            self.register_buffer("weight", vectors.clone(), persistent=False)

    def forward(self, words: torch.Tensor) -> torch.Tensor:
        """``(..., width)`` of rows ``(...)``."""
        return functional.embedding(words, self.weight)


def word_vectors(known: torch.Tensor, trained: bool, seed: int = 0) -> torch.Tensor:
    """Rows of a word table from the data set's own ``(W, width)``.

    Special rows of a trained table are drawn as published, those of a frozen one but UNKNOWN are zero.
    """
    generator = torch.Generator().manual_seed(seed)
    special = torch.randn(SPECIAL, known.shape[1], generator=generator) * known.shape[1] ** -0.5
    if not trained:
        special[PAD] = 0
    return torch.cat([special, known.float().cpu()])
