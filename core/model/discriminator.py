"""Affective discriminator: does a performance look real? (paper section 3.2, reference section A.8)."""

import torch
from torch import nn

from ..skeleton import MEAN
from .affective_encoder import AffectiveEncoder
from .config import ModelConfig
from .layers import make_gru, run_gru


class Discriminator(nn.Module):
    """An affective encoder of its own, a bidirectional GRU and a score."""

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.aff_encoder = AffectiveEncoder(config)
        self.gru = make_gru(
            config.affect_size, config.discriminator_size, config.discriminator_layers, config.discriminator_dropout
        )
        self.out = nn.Linear(config.discriminator_size, 1)
        self.out2 = nn.Linear(config.frames, 1) if config.discriminator_pool == "linear" else None
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    def forward(self, directions: torch.Tensor) -> torch.Tensor:
        """Probability ``(B, 1)`` that ``directions`` ``(B, T, 9, 3)`` were performed, not generated (paper eq. 14)."""
        scores = self.out(run_gru(self.gru, self.aff_encoder(directions - self.mean))).squeeze(-1).float()
        scores = self.out2(scores) if self.out2 is not None else scores.mean(1, keepdim=True)
        return torch.sigmoid(scores.float())
