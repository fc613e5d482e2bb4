"""Gesture generator: encoders, a bidirectional GRU and a head (paper section 3.1.5, reference section A.7)."""

import torch
from torch import nn
from torch.nn import functional

from ..motion.skeleton import EDGES
from .config import ModelConfig
from .encoders import POSE, Encoders
from .layers import in_float32, make_gru, run_gru


class Generator(Encoders):
    """Predicts directions from voice, words, prosody, seed poses and style."""

    def __init__(self, config: ModelConfig):
        super().__init__(config)
        self.gru = make_gru(self.feature_size + config.style_size, config.gru_size, config.gru_layers, config.gru_dropout)
        self.out = nn.Sequential(
            nn.Linear(config.gru_size, config.head_size),
            nn.LeakyReLU(config.head_slope),
            nn.Linear(config.head_size, POSE),
        )

    def decode(self, features: torch.Tensor, style: torch.Tensor) -> torch.Tensor:
        """Predict directions ``(B, T, 9, 3)`` from the features of :meth:`encode` and styles ``(B, style_size)``.

        Styles that vary over time are ``(B, T, style_size)``.
        """
        # The style goes between text and seed features to match the column order of the public code's GRU.
        repeated = style if style.dim() == 3 else style[:, None].expand(-1, features.shape[1], -1)
        head = self.config.seed_size + self.config.mfcc_size + self.config.text_size
        inputs = torch.cat([features[..., :head], repeated, features[..., head:]], dim=-1)
        hidden = run_gru(self.gru, inputs)
        poses = in_float32(self.out, hidden).unflatten(-1, (len(EDGES), 3)) + self.mean
        return functional.normalize(poses, dim=-1) if self.config.unit_directions else poses

    def forward(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        style: torch.Tensor,
        prosody: torch.Tensor | None = None,
        asked: torch.Tensor | None = None,
        noise: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Predict directions ``(B, T, 9, 3)``, seed frames included; unit vectors if the configuration says so.

        ``seeds`` ``(B, T, 28)``: mean-subtracted directions on the seed frames and zeros elsewhere, last channel 1 on
        seed frames; ``style`` ``(B, style_size)``; ``prosody`` ``(B, T, prosody_features)`` if the configuration has it.
        A regressor ignores stroke requests (``asked``) and ``noise``.
        """
        return self.decode(self.encode(mfcc, words, seeds, prosody), style)
