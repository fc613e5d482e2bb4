"""A judge of affect in motion: a small network that learns arousal, valence and dominance from the corpus's bodies.

Its opinion of what a flow is about to draw is a term of the flow's loss, as the paper's affective discriminator is of the
regressor's: motion has to show the affect that was heard.
"""

import torch
from torch import nn
from torch.nn import functional

from ...settings import AFFECTS

_SIZE, _KERNEL, _STRIDE = 48, 5, 2
STEP = _STRIDE**2
"""Frames from one estimate to the next."""


class AffectJudge(nn.Module):
    """Estimates affect from normalised poses."""

    def __init__(self, channels: int):
        super().__init__()
        self.first = nn.Conv1d(2 * channels, _SIZE, _KERNEL, _STRIDE, _KERNEL // 2)
        self.second = nn.Conv1d(_SIZE, _SIZE, _KERNEL, _STRIDE, _KERNEL // 2)
        self.third = nn.Conv1d(_SIZE, _SIZE, _KERNEL, 1, 2 * (_KERNEL // 2), 2)
        self.out = nn.Conv1d(_SIZE, len(AFFECTS), 1)

    def forward(self, poses: torch.Tensor) -> torch.Tensor:
        """Return affect ``(B, T / STEP, 3)`` of poses ``(B, T, channels)``, from where they are and how they move."""
        moves = 4 * poses.diff(dim=1, prepend=poses[:, :1])
        hidden = functional.silu(self.first(torch.cat([poses, moves.abs()], -1).transpose(1, 2)))
        hidden = functional.silu(self.third(functional.silu(self.second(hidden))))
        return self.out(hidden).transpose(1, 2)


def error(estimates: torch.Tensor, affect: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Return the mean squared error of estimates ``(B, T / STEP, 3)`` of affect ``(B, T, 3)``; ``weights`` are ``(B,)``."""
    squares = (estimates.float() - affect[:, ::STEP]).square().mean((1, 2))
    return (squares * weights).mean()
