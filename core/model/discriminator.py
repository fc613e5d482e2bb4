"""Discriminators of real and generated motion: the affective one and GTC's (paper section 3.2, reference A.8 and G.4)."""

import torch
from torch import nn

from ..motion.skeleton import EDGES, MEAN
from .affective_encoder import AffectiveEncoder
from .config import ModelConfig
from .layers import make_gru, make_norm, run_gru


class Discriminator(nn.Module):
    """A separate affective encoder (or three convolutions), a bidirectional GRU and a score."""

    mean: torch.Tensor

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.config = config
        if config.affect == "graph":
            self.aff_encoder = AffectiveEncoder(config)
        else:
            a, b, c = config.discriminator_channels
            self.pre_conv = nn.Sequential(
                nn.Conv1d(len(EDGES) * 3, a, 3), make_norm(config.norm, a), nn.LeakyReLU(config.head_slope),
                nn.Conv1d(a, b, 3), make_norm(config.norm, b), nn.LeakyReLU(config.head_slope), nn.Conv1d(b, c, 3),
            )  # fmt: skip
        self.gru = make_gru(
            config.affect_size if config.affect == "graph" else config.discriminator_channels[-1],
            config.discriminator_size,
            config.discriminator_layers,
            config.discriminator_dropout,
        )
        self.out = nn.Linear(config.discriminator_size, 1)
        self.out2 = (
            nn.Linear(config.frames - (0 if config.affect == "graph" else 6), 1)
            if config.discriminator_pool == "linear"
            else None
        )
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    def forward(self, directions: torch.Tensor) -> torch.Tensor:
        """Return the probability ``(B, 1)`` that ``directions`` ``(B, T, 9, 3)`` are recorded, not generated (eq. 14)."""
        poses = directions - self.mean
        if self.config.affect == "graph":
            features = self.aff_encoder(poses)
        else:
            features = self.pre_conv(poses.flatten(2).transpose(1, 2)).transpose(1, 2)
        scores = self.out(run_gru(self.gru, features)).squeeze(-1).float()
        scores = self.out2(scores) if self.out2 is not None else scores.mean(1, keepdim=True)
        return torch.sigmoid(scores.float())
