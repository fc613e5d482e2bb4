"""Small layers that the encoders share."""

from typing import Any, cast

import torch
from torch import nn
from torch.nn import functional

from . import recurrent


class ChannelNorm(nn.Module):
    """Layer normalisation over the channels (axis 1) of every frame, with any trailing axes.

    Unlike batch normalisation it is the same in training and evaluation, and for any batch size and length.
    """

    def __init__(self, channels: int):
        super().__init__()
        self.weight = nn.Parameter(torch.ones(channels))
        self.bias = nn.Parameter(torch.zeros(channels))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Normalise ``x``; the result has the same shape."""
        if x.device.type == "cpu":
            return cast(torch.Tensor, _ChannelNorm.apply(x, self.weight, self.bias))
        return functional.layer_norm(x.movedim(1, -1), self.weight.shape, self.weight, self.bias).movedim(-1, 1)


class _ChannelNorm(torch.autograd.Function):
    """Layer normalisation over axis 1 without transposes, which on a CPU take longer than the sums."""

    @staticmethod
    def forward(ctx: Any, x: torch.Tensor, weight: torch.Tensor, bias: torch.Tensor) -> torch.Tensor:
        shape = (-1, *[1] * (x.dim() - 2))
        centred = x.float() if x.dtype != torch.float64 else x
        centred = centred - centred.mean(1, keepdim=True)
        scale = centred.square().mean(1, keepdim=True).add_(1e-5).rsqrt_()
        unit = centred.mul_(scale)
        ctx.save_for_backward(unit, scale, weight)
        return torch.addcmul(bias.view(shape), unit, weight.view(shape)).to(x.dtype)

    @staticmethod
    def backward(ctx: Any, *grad_outputs: torch.Tensor) -> tuple[torch.Tensor, ...]:
        (grad,), (unit, scale, weight) = grad_outputs, ctx.saved_tensors
        along = grad * unit
        other_axes = [0, *range(2, grad.dim())]
        grad_weight, grad_bias = along.sum(other_axes), grad.sum(other_axes, dtype=weight.dtype)
        weight = weight.view(-1, *[1] * (grad.dim() - 2))
        mean = (grad * weight).mean(1, keepdim=True)
        slope = along.mul_(weight).mean(1, keepdim=True)
        grad_x = (grad * weight).sub_(mean).sub_(unit * slope).mul_(scale)
        return grad_x.to(grad.dtype), grad_weight, grad_bias


def make_norm(kind: str, channels: int, axes: int = 1) -> nn.Module:
    """Create the normalisation named ``kind`` for ``(B, channels, ...)`` with ``axes`` trailing axes."""
    if kind == "layer":
        return ChannelNorm(channels)
    return (nn.BatchNorm1d if axes == 1 else nn.BatchNorm2d)(channels)


class WeightNormConv1d(nn.Module):
    """Convolution along time with weight normalisation (direction ``weight_v``, length ``weight_g``); keeps the length.

    ``causal`` pads on the left only, so that a frame depends on no later one.
    """

    def __init__(self, channels: int, kernel: int, dilation: int, causal: bool):
        super().__init__()
        initial = nn.Conv1d(channels, channels, kernel)
        assert initial.bias is not None
        self.weight_v = nn.Parameter(initial.weight.detach().clone())
        self.weight_g = nn.Parameter(self.weight_v.detach().norm(dim=(1, 2), keepdim=True))
        self.bias = nn.Parameter(initial.bias.detach().clone())
        self.dilation = dilation
        reach = (kernel - 1) * dilation
        self.padding = (reach, 0) if causal else (reach // 2, reach - reach // 2)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map ``(B, C, T)`` to the same shape."""
        weight = self.weight_v * (self.weight_g / self.weight_v.norm(dim=(1, 2), keepdim=True))
        return functional.conv1d(functional.pad(x, self.padding), weight, self.bias, dilation=self.dilation)


def make_gru(inputs: int, size: int, layers: int, dropout: float) -> nn.GRU:
    """Create a bidirectional GRU over ``(B, T, inputs)``; dropout acts between layers."""
    return nn.GRU(inputs, size, layers, batch_first=True, bidirectional=True, dropout=dropout if layers > 1 else 0.0)


def run_gru(gru: nn.GRU, x: torch.Tensor) -> torch.Tensor:
    """Return the sum of the forward and the backward outputs, ``(B, T, size)`` (paper eq. 8, 9, 12 and 13)."""
    if gru.training and x.device.type == "cpu":
        forward, backward = recurrent.bidirectional(gru, x)
    else:
        forward, backward = gru(x)[0].chunk(2, dim=-1)
    return forward + backward


def in_float32(layer: nn.Module, x: torch.Tensor) -> torch.Tensor:
    """Apply ``layer`` in float32 regardless of autocast: poses differ little from frame to frame."""
    with torch.autocast(x.device.type, enabled=False):
        return layer(x.float())
