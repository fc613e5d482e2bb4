"""Seq2Seq: words to poses by a decoder with attention (Yoon et al. 2019, reference section G.1)."""

import torch
from torch import nn
from torch.nn import functional
from torch.nn.utils.rnn import pack_padded_sequence, pad_packed_sequence

from .sample import PAD, POSE, Sample, WordTable, word_vectors
from .system import Generated, System, scale_width


class Seq2Seq(System):
    """A bidirectional GRU over the words, and an autoregressive GRU over poses that attends to it.

    Padding is masked in the attention. ``trained_words`` says whether the word table is trained.
    """

    rate = 1e-4
    mixed = False
    clip = 5.0

    def __init__(self, vectors: torch.Tensor, trained_words: bool = True, share: float = 1.0):
        super().__init__()
        self.performer = _Network(WordTable(word_vectors(vectors, trained_words), trained_words), scale_width(200, share))

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate with the true previous poses in frames 1 to 3 (teacher forcing), and its own later."""
        return Generated(self.perform(sample))

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the published terms: squared error, a penalty on frame-to-frame motion, a reward for motion over time."""
        poses = (made.directions - self.mean).flatten(2)
        count = poses.numel()
        return {
            "squares": 250 * functional.mse_loss(poses, sample.poses),
            "continuity": 0.1 * poses.diff(dim=1).abs().sum() / count,
            "variance": -25 * torch.linalg.vector_norm(poses, dim=1).sum() / count,
        }

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate step by step; frame 0 is given."""
        poses = sample.poses
        return self.directions(self.performer(*sample.sequences(), poses[:, : sample.seed_frames], poses.shape[1]))


class _Network(nn.Module):
    def __init__(self, table: WordTable, size: int):
        super().__init__()
        self.table, self.size = table, size
        self.encoder = nn.GRU(table.weight.shape[1], size, 2, batch_first=True, bidirectional=True, dropout=0.1)
        self.attend, self.energy = nn.Linear(2 * size, size), nn.Linear(size, 1, bias=False)
        self.enter = nn.Sequential(nn.Linear(POSE + size, size), nn.BatchNorm1d(size), nn.ReLU())
        self.decoder = nn.GRU(size, size, 2, batch_first=True, dropout=0.1)
        self.out = nn.Linear(size, POSE)

    def forward(self, words: torch.Tensor, lengths: torch.Tensor, given: torch.Tensor, frames: int) -> torch.Tensor:
        """Return mean-subtracted poses ``(B, frames, 27)``."""
        packed = pack_padded_sequence(self.table(words), lengths, batch_first=True, enforce_sorted=False)
        outputs, state = self.encoder(packed)
        encoded = pad_packed_sequence(outputs, batch_first=True)[0].unflatten(-1, (2, self.size)).sum(2)
        is_padding = words[:, : encoded.shape[1]] == PAD
        state = state[:2].contiguous()  # as published: both directions of the first layer initialise the decoder's two layers
        keys = functional.linear(encoded, self.attend.weight[:, self.size :], self.attend.bias)
        poses = [given[:, 0]]
        for frame in range(1, frames):
            previous = given[:, frame - 1] if frame - 1 < given.shape[1] else poses[-1]
            query = functional.linear(state[-1], self.attend.weight[:, : self.size])
            energy = self.energy(torch.tanh(query[:, None] + keys)).squeeze(-1).masked_fill(is_padding, -torch.inf)
            context = torch.einsum("bl,bls->bs", energy.softmax(1), encoded)
            step, state = self.decoder(self.enter(torch.cat([previous, context], 1))[:, None], state)
            poses.append(self.out(step[:, 0]))
        return torch.stack(poses, 1)
