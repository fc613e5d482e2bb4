"""Small layers that the encoders share."""

import torch
from torch import nn
from torch.nn import functional

from . import recurrent


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
        if x.device.type == "cpu":
            return _ChannelNorm.apply(x, self.weight, self.bias)
        return functional.layer_norm(x.movedim(1, -1), self.weight.shape, self.weight, self.bias).movedim(-1, 1)


class _ChannelNorm(torch.autograd.Function):
    """Layer normalisation over axis 1 in place: on a CPU, to turn the axes round and back takes longer than the sums."""

    @staticmethod
    def forward(ctx, x, weight, bias):
        shape = (-1, *[1] * (x.dim() - 2))
        centred = x.float() if x.dtype != torch.float64 else x
        centred = centred - centred.mean(1, keepdim=True)
        scale = centred.square().mean(1, keepdim=True).add_(1e-5).rsqrt_()
        unit = centred.mul_(scale)
        ctx.save_for_backward(unit, scale, weight)
        return torch.addcmul(bias.view(shape), unit, weight.view(shape)).to(x.dtype)

    @staticmethod
    def backward(ctx, grad):
        unit, scale, weight = ctx.saved_tensors
        along = grad * unit
        others = [0, *range(2, grad.dim())]
        grad_weight, grad_bias = along.sum(others), grad.sum(others, dtype=weight.dtype)
        weight = weight.view(-1, *[1] * (grad.dim() - 2))
        mean = (grad * weight).mean(1, keepdim=True)
        slope = along.mul_(weight).mean(1, keepdim=True)
        grad_x = (grad * weight).sub_(mean).sub_(unit * slope).mul_(scale)
        return grad_x.to(grad.dtype), grad_weight, grad_bias


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
    if gru.training and x.device.type == "cpu":
        forward, backward = recurrent.bidirectional(gru, x)
    else:
        forward, backward = gru(x)[0].chunk(2, dim=-1)
    return forward + backward


def exact(layer: nn.Module, x: torch.Tensor) -> torch.Tensor:
    """``layer`` in float32 whatever the training's precision: poses differ little from frame to frame."""
    with torch.autocast(x.device.type, enabled=False):
        return layer(x.float())
