"""Encoder of the raw waveform: GTC's, and that of the paper's ablation without MFCCs (reference section A.10)."""

import torch
from torch import nn
from torch.nn import functional

SAMPLES = 36267
"""Audio samples at 16 kHz of a window of 34 pose frames."""
FRAMES = 34
_SLOPE = 0.3


class StridedConv1d(nn.Conv1d):
    """``nn.Conv1d`` with a stride and no dilation, its input cut into blocks of one stride first.

    The blocks' samples become channels, so that the convolution itself has no stride: PyTorch's CPU kernels are slow at
    few channels and long strides.
    """

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """``(B, C, samples)`` to ``(B, outputs, frames)``, the same values."""
        (kernel,), (stride,), (padding,) = self.kernel_size, self.stride, self.padding
        taps = -(-kernel // stride)
        frames = (x.shape[-1] + 2 * padding - kernel) // stride + 1
        x = functional.pad(x, (padding, (frames + taps - 1) * stride - x.shape[-1] - padding))
        weight = functional.pad(self.weight, (0, taps * stride - kernel))
        x, weight = (part.unflatten(-1, (-1, stride)).transpose(2, 3).flatten(1, 2) for part in (x, weight))
        return functional.conv1d(x, weight, self.bias)


class WaveEncoder(nn.Module):
    """Four strided convolutions that turn exactly :data:`SAMPLES` samples into exactly 34 frames."""

    def __init__(self, size: int = 32):
        super().__init__()
        self.feat_extractor = nn.Sequential(
            StridedConv1d(1, 16, 15, stride=5, padding=1600), nn.BatchNorm1d(16), nn.LeakyReLU(_SLOPE),
            StridedConv1d(16, 32, 15, stride=6), nn.BatchNorm1d(32), nn.LeakyReLU(_SLOPE),
            StridedConv1d(32, 64, 15, stride=6), nn.BatchNorm1d(64), nn.LeakyReLU(_SLOPE),
            StridedConv1d(64, size, 15, stride=6),
        )  # fmt: skip

    def forward(self, wave: torch.Tensor, frames: int = FRAMES) -> torch.Tensor:
        """Features ``(B, frames, size)`` of ``(B, samples)`` in -1..1, padded with silence or cut to :data:`SAMPLES`."""
        wave = functional.pad(wave, (0, SAMPLES - wave.shape[-1]))
        return self.feat_extractor(wave[:, None]).transpose(1, 2)[:, :frames]
