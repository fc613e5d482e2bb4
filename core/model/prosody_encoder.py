"""Prosody encoder: accents, phrases and pauses at the pose rate, which time the strokes (not in the paper)."""

import torch
from torch import nn
from torch.nn import functional

from .config import ModelConfig
from .layers import make_norm


class ProsodyEncoder(nn.Module):
    """Two convolutions along time."""

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.slope = config.mfcc_slope
        self.conv1 = nn.Conv1d(config.prosody_features, 2 * config.prosody_size, 5, padding=2)
        self.batch_norm1 = make_norm(config.norm, 2 * config.prosody_size)
        self.conv2 = nn.Conv1d(2 * config.prosody_size, config.prosody_size, 3, padding=1)

    def forward(self, prosody: torch.Tensor) -> torch.Tensor:
        """Map ``(B, T, features)`` of :func:`prosody.analyse` to ``(B, T, prosody_size)``."""
        x = functional.leaky_relu(self.batch_norm1(self.conv1(prosody.transpose(1, 2))), self.slope)
        return functional.leaky_relu(self.conv2(x).transpose(1, 2), self.slope)
