"""MFCC encoder: voice features for each pose frame (paper section 3.1.1, reference section A.3)."""

import torch
from torch import nn
from torch.nn import functional

from .config import ModelConfig
from .layers import make_norm


class MfccEncoder(nn.Module):
    """Convolutions, then one fully connected layer.

    Along time, the input ``(B, Ta, features)`` may have any length and is resampled to the pose frames. Along the
    coefficients, as in the public code, the input is ``(B, features, Ta)`` with both lengths fixed, and the last
    convolution's channels are the pose frames. Surplus features are cut off: 37 of 40 are all but the last three
    second-order differences.
    """

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.along_time = config.mfcc_axis == "time"
        self.features = config.mfcc_features
        self.slope = config.mfcc_slope
        self.count = len(config.mfcc_channels)
        channels = (config.mfcc_features if self.along_time else config.mfcc_frames, *config.mfcc_channels)
        for i, kernel in enumerate(config.mfcc_kernels):
            setattr(self, f"conv{i + 1}", nn.Conv1d(channels[i], channels[i + 1], kernel, padding=kernel // 2))
            setattr(self, f"batch_norm{i + 1}", make_norm(config.norm, channels[i + 1]))
        self.linear1 = nn.Linear(channels[-1] if self.along_time else config.mfcc_features, config.mfcc_size)

    def forward(self, mfcc: torch.Tensor, frames: int) -> torch.Tensor:
        """Encode ``mfcc`` as features ``(B, frames, mfcc_size)``."""
        x = (mfcc[..., : self.features] if self.along_time else mfcc).transpose(1, 2)
        for i in range(1, self.count + 1):
            x = getattr(self, f"batch_norm{i}")(getattr(self, f"conv{i}")(x))
            x = functional.leaky_relu(x, self.slope)
        if self.along_time:
            x = functional.interpolate(x, size=frames, mode="linear", align_corners=False).transpose(1, 2)
        return functional.leaky_relu(self.linear1(x), self.slope)
