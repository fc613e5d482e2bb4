"""Encoder of the raw waveform, for GTC and the paper's ablation without MFCCs (reference section A.10)."""

import torch
from torch import nn
from torch.nn import functional

SAMPLES = 36267
"""Samples at 16 kHz in a window of 34 pose frames."""
FRAMES = 34
_SLOPE = 0.3


class WaveEncoder(nn.Module):
    """Four strided convolutions that map exactly :data:`SAMPLES` samples to exactly 34 frames."""

    def __init__(self, size: int = 32, channels: tuple[int, ...] = (16, 32, 64)):
        super().__init__()
        a, b, c = channels
        self.feat_extractor = nn.Sequential(
            nn.Conv1d(1, a, 15, stride=5, padding=1600), nn.BatchNorm1d(a), nn.LeakyReLU(_SLOPE),
            nn.Conv1d(a, b, 15, stride=6), nn.BatchNorm1d(b), nn.LeakyReLU(_SLOPE),
            nn.Conv1d(b, c, 15, stride=6), nn.BatchNorm1d(c), nn.LeakyReLU(_SLOPE),
            nn.Conv1d(c, size, 15, stride=6),
        )  # fmt: skip

    def forward(self, wave: torch.Tensor, frames: int = FRAMES) -> torch.Tensor:
        """Encode samples ``(B, samples)`` in -1..1, padded with silence or cut to :data:`SAMPLES`, as ``(B, frames, size)``."""
        wave = functional.pad(wave, (0, SAMPLES - wave.shape[-1]))
        return self.feat_extractor(wave[:, None]).transpose(1, 2)[:, :frames]
