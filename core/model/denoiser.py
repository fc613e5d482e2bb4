"""Velocity network of the flow: depthwise convolutions along time, modulated by speech features and flow time.

Blocks after Liu et al. 2022 (A ConvNet for the 2020s), conditioned as in Peebles and Xie 2023 (adaptive layer norm).
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, cast

import torch
from torch import nn
from torch.nn import functional

from .config import ModelConfig

_FREQUENCIES = 32
_NORM_EPSILON = 1e-5


Film = Sequence[torch.Tensor]
"""Scale and shift ``(B, T, size)`` of a block (feature-wise linear modulation)."""


class Conditions(NamedTuple):
    """An offset ``(B, T, size)`` added to the input of the blocks, and each block's scales and shifts."""

    heard: torch.Tensor
    films: list[Film]


class Depthwise(nn.Module):
    """Depthwise convolution along time of ``(B, T, channels)``; keeps the length."""

    def __init__(self, channels: int, kernel: int, dilation: int):
        super().__init__()
        self.weight = nn.Parameter(torch.empty(kernel, channels).uniform_(-1, 1) * kernel**-0.5)
        self.dilation = dilation

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Convolve ``x``; the result has the same shape."""
        return cast(torch.Tensor, _Depthwise.apply(x, self.weight.to(x.dtype), self.dilation))


class _Depthwise(torch.autograd.Function):
    """Weighted sum of shifted copies: on a CPU twice as fast as a grouped convolution."""

    @staticmethod
    def forward(ctx: Any, x: torch.Tensor, weight: torch.Tensor, dilation: int) -> torch.Tensor:
        ctx.dilation = dilation
        ctx.save_for_backward(x, weight)
        return _shifted_sum(x, weight, dilation)

    @staticmethod
    def backward(ctx: Any, *grad_outputs: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        (grad,), (x, weight) = grad_outputs, ctx.saved_tensors
        reach, frames = ctx.dilation * (len(weight) // 2), x.shape[1]
        padded = functional.pad(x, (0, 0, reach, reach))
        taps = [(padded[:, k * ctx.dilation : k * ctx.dilation + frames] * grad).sum((0, 1)) for k in range(len(weight))]
        return _shifted_sum(grad, weight.flip(0), ctx.dilation), torch.stack(taps), None


def _shifted_sum(x: torch.Tensor, weight: torch.Tensor, dilation: int) -> torch.Tensor:
    reach, frames = dilation * (len(weight) // 2), x.shape[1]
    padded = functional.pad(x, (0, 0, reach, reach))
    total = padded[:, :frames] * weight[0]
    for k in range(1, len(weight)):
        total.addcmul_(padded[:, k * dilation : k * dilation + frames], weight[k])
    return total


class Block(nn.Module):
    """A residual block: depthwise convolution, modulation, and two linear layers."""

    def __init__(self, config: ModelConfig, dilation: int):
        super().__init__()
        size, wide = config.flow_size, config.flow_size * config.flow_expand
        self.conv = Depthwise(size, config.flow_kernel, dilation)
        self.scale, self.shift = (nn.Linear(config.flow_condition, size) for _ in range(2))
        self.widen = nn.Linear(size, wide)
        self.narrow = nn.Linear(wide, size)
        for part, start in ((self.scale, 1.0), (self.shift, 0.0)):
            nn.init.zeros_(part.weight)
            nn.init.constant_(part.bias, start)

    def film(self, wide: torch.Tensor) -> Film:
        """Return scale and shift for conditions ``(B, T, flow_condition)``."""
        return self.scale(wide), self.shift(wide)

    def forward(self, x: torch.Tensor, film: Film) -> torch.Tensor:
        """Map ``(B, T, size)`` to the same shape."""
        scale, shift = film
        y = functional.layer_norm(self.conv(x), x.shape[-1:], eps=_NORM_EPSILON)
        return x + self.narrow(functional.silu(self.widen(torch.addcmul(shift, y, scale))))


class Denoiser(nn.Module):
    """Predicts velocities from noisy poses and conditions, in tokens of ``flow_patch`` frames.

    ``channels`` and ``features`` are the sizes of a frame and of its conditions. Scales and shifts are linear in conditions
    and time, so that the part of the conditions is computed once for all solver steps (:meth:`condition`).
    """


    def __init__(self, config: ModelConfig, channels: int, features: int):
        super().__init__()
        self.patch, size, wide = config.flow_patch, config.flow_size, config.flow_condition
        self.into = nn.Conv1d(self.patch * (channels + 1), size, 3, padding=1)
        self.heard = nn.Linear(self.patch * features, size)
        self.features = nn.Sequential(nn.Linear(self.patch * features, wide), nn.SiLU(), nn.Linear(wide, wide))
        self.time = nn.Sequential(nn.Linear(2 * _FREQUENCIES, wide), nn.SiLU(), nn.Linear(wide, wide))
        self.blocks = nn.ModuleList(Block(config, dilation) for dilation in config.flow_dilations)
        self.norm = nn.LayerNorm(size)
        self.out = nn.Conv1d(size, self.patch * channels, 3, padding=1)
        assert self.out.bias is not None
        nn.init.zeros_(self.out.weight)
        nn.init.zeros_(self.out.bias)

    def condition(self, features: torch.Tensor, time: torch.Tensor | None = None) -> Conditions:
        """Prepare conditions ``(B, T, features)`` for the blocks; with times ``(B,)`` they hold for those times alone."""
        tokens = self._fold(features)
        wide = self.features(tokens)
        if time is not None:
            wide = wide + self._moment(time)
        return Conditions(self.heard(tokens), [block.film(wide) for block in self._blocks()])

    def forward(
        self, x: torch.Tensor, mask: torch.Tensor, conditions: Conditions, time: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Return velocities ``(B, T, channels)`` of ``x`` at ``time`` ``(B,)``; ``mask`` ``(B, T, 1)`` is 1 on given frames.

        ``time`` is None if it is already part of the conditions.
        """
        tokens = self._fold(torch.cat([x, mask.expand(len(x), -1, -1)], -1))
        hidden = self.into(tokens.transpose(1, 2)).transpose(1, 2) + conditions.heard
        moment = None if time is None else self._moment(time)
        for block, film in zip(self._blocks(), conditions.films, strict=True):
            if moment is not None:
                film = [
                    part + functional.linear(moment, layer.weight)
                    for part, layer in zip(film, (block.scale, block.shift), strict=True)
                ]
            hidden = block(hidden, film)
        velocities = self.out(self.norm(hidden).transpose(1, 2)).transpose(1, 2)
        return velocities.unflatten(-1, (self.patch, -1)).flatten(1, 2)[:, : x.shape[1]]

    def _blocks(self) -> Iterable[Block]:
        return cast(Iterable[Block], self.blocks)

    def _moment(self, time: torch.Tensor) -> torch.Tensor:
        return self.time(_time_encoding(time))[:, None]

    def _fold(self, x: torch.Tensor) -> torch.Tensor:
        """Group frames ``(B, T, C)`` into tokens ``(B, T / patch, patch C)``; the last one is padded with zeros."""
        x = functional.pad(x, (0, 0, 0, -x.shape[1] % self.patch))
        return x.unflatten(1, (-1, self.patch)).flatten(2)


def _time_encoding(time: torch.Tensor) -> torch.Tensor:
    """Encode times in 0..1 as sines and cosines ``(B, 64)`` (Vaswani et al. 2017)."""
    rates = 1000 * torch.exp(-math.log(1000) * torch.arange(_FREQUENCIES, device=time.device) / _FREQUENCIES)
    angles = time.float()[:, None] * rates
    return torch.cat([angles.sin(), angles.cos()], -1)
