"""JEM: a joint embedding of speech and motion with a pose decoder (Ahuja and Morency 2019, reference section G.3)."""

from typing import cast

import torch
from torch import nn
from torch.nn import functional

from ...model import paper_networks
from ...model.layers import in_float32, make_gru, run_gru
from ...model.text_encoder import TextEncoder
from ...model.wave_encoder import FRAMES, WaveEncoder
from ..metrics.extractor import Extractor
from .sample import POSE, Sample, WordTable, word_vectors
from .system import Generated, System, scale_small_width, scale_width

LATENT = 32


class JointEmbedding(System):
    """An encoder of words and sound, an encoder of motion, and one decoder for both latents.

    As in the public code it takes audio, too, although the paper calls it text-only (reference A.11, 25); ``audio=False``
    follows the paper. The first text layer reduces 300 channels to 200 by a projection, where the public code has a 1x1
    shortcut around a wider convolution.
    """

    def __init__(
        self,
        vectors: torch.Tensor,
        trained_words: bool = True,
        audio: bool = True,
        share: float = 1.0,
        given: int = 4,
        frames: int = FRAMES,
    ):
        super().__init__()
        table = WordTable(word_vectors(vectors, trained_words), trained_words)
        self.performer = _Network(table, audio, share, given, frames)

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate the whole batch from speech or from the motion itself, at random."""
        return Generated(self._decode(sample, from_speech=bool(torch.rand(()) < 0.5)))

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the L1 loss, summed over the batch as published."""
        return {"places": functional.l1_loss(made.directions, sample.directions) * len(sample.directions)}

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate from speech."""
        return self._decode(sample, from_speech=True)

    def _decode(self, sample: Sample, from_speech: bool) -> torch.Tensor:
        network, given = cast(_Network, self.performer), sample.poses[:, : sample.seed_frames]
        latent = network.hear(sample.words, sample.wave) if from_speech else network.motion(sample.poses.transpose(1, 2))
        return self.directions(network.decode(latent, given, sample.poses.shape[1]))


class _Network(nn.Module):
    def __init__(self, table: WordTable, audio: bool, share: float, given: int, frames: int):
        super().__init__()
        self.table = table
        features, inner = scale_small_width(32, share), scale_width(128, share)
        sizes = {"text_channels": scale_width(200, share), "text_size": features, "word_size": table.weight.shape[1]}
        self.text = TextEncoder(paper_networks.published(words=0, text_levels=2, **sizes))
        a, b, c = (scale_small_width(channels, share) for channels in (16, 32, 64))
        self.audio = WaveEncoder(features, (a, b, c)) if audio else None
        size = scale_width(256, share)
        self.context = nn.GRU(2 * features if audio else features, size, 2, batch_first=True)
        self.enter = nn.Sequential(nn.Linear(size, inner), nn.BatchNorm1d(inner), nn.ReLU(), nn.Linear(inner, LATENT))
        self.mu, self.log_var = nn.Linear(LATENT, LATENT), nn.Linear(LATENT, LATENT)
        self.motion = Extractor(frames=frames).encoder
        layers = nn.LazyLinear(features), nn.BatchNorm1d(features), nn.ReLU(), nn.Linear(features, features)
        self.pose = nn.Sequential(*layers)
        self.pose(torch.zeros(2, given * POSE))
        size = scale_width(300, share)
        self.gru = make_gru(LATENT + features, size, 4, 0.3)
        self.out = nn.Sequential(nn.Linear(size, size // 2), nn.LeakyReLU(0.01), nn.Linear(size // 2, POSE))

    def hear(self, words: torch.Tensor, wave: torch.Tensor) -> torch.Tensor:
        """Sample a latent ``(B, 32)`` for speech."""
        features = [self.text(self.table(words))] + ([self.audio(wave)] if self.audio is not None else [])
        state = self.enter(self.context(torch.cat(features, -1))[0][:, -1])
        return self.mu(state) + torch.randn_like(state) * torch.exp(0.5 * self.log_var(state))

    def decode(self, latent: torch.Tensor, given: torch.Tensor, frames: int) -> torch.Tensor:
        """Return poses ``(B, frames, 27)`` for a latent and the given poses."""
        x = torch.cat([self.pose(given.flatten(1)), latent], 1)[:, None].expand(-1, frames, -1)
        return in_float32(self.out, run_gru(self.gru, x))
