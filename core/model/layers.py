"""Small layers that the encoders share."""

import torch
from torch import nn
from torch.nn import functional


class ChannelNorm(nn.Module):
    """Layer normalisation over the channels (axis 1) of every frame, whatever axes follow.

    Unlike batch statistics it behaves the same in training and use, for one window and for many, at any length.
    """

    def __init__(self, channels: int):
        super().__init__()
        self.weight = nn.Parameter(torch.ones(channels))
        self.bias = nn.Parameter(torch.zeros(channels))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Normalised ``x``, same shape."""
        return functional.layer_norm(x.movedim(1, -1), self.weight.shape, self.weight, self.bias).movedim(-1, 1)


def make_norm(kind: str, channels: int, axes: int = 1) -> nn.Module:
    """The normalisation ``kind`` names for ``(B, channels, ...)`` with ``axes`` trailing axes."""
    if kind == "layer":
        return ChannelNorm(channels)
    return (nn.BatchNorm1d if axes == 1 else nn.BatchNorm2d)(channels)


class WeightNormConv1d(nn.Module):
    """Convolution along time whose kernels are a direction ``weight_v`` and a length ``weight_g``, output as long as input.

    ``causal`` pads on the left only, so a frame sees nothing that comes later.
    """

    def __init__(self, channels: int, kernel: int, dilation: int, causal: bool):
        super().__init__()
        start = nn.Conv1d(channels, channels, kernel)
        self.weight_v = nn.Parameter(start.weight.detach().clone())
        self.weight_g = nn.Parameter(self.weight_v.detach().norm(dim=(1, 2), keepdim=True))
        self.bias = nn.Parameter(start.bias.detach().clone())
        self.dilation = dilation
        reach = (kernel - 1) * dilation
        self.padding = (reach, 0) if causal else (reach // 2, reach - reach // 2)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """``(B, C, T)`` to the same shape."""
        weight = self.weight_v * (self.weight_g / self.weight_v.norm(dim=(1, 2), keepdim=True))
        return functional.conv1d(functional.pad(x, self.padding), weight, self.bias, dilation=self.dilation)


def make_gru(inputs: int, size: int, layers: int, dropout: float) -> nn.GRU:
    """Bidirectional GRU over ``(B, T, inputs)``; dropout acts between layers."""
    return nn.GRU(inputs, size, layers, batch_first=True, bidirectional=True, dropout=dropout if layers > 1 else 0.0)


def run_gru(gru: nn.GRU, x: torch.Tensor) -> torch.Tensor:
    """Sum of the forward and the backward outputs, ``(B, T, size)`` (paper eq. 8, 9, 12 and 13)."""
    forward, backward = gru(x)[0].chunk(2, dim=-1)
    return forward + backward
