"""Encoder of requested strokes, which lets a user request a gesture at a word (not in the paper)."""

import torch
from torch import nn
from torch.nn import functional

from ..motion.stroke_requests import CHANNELS
from .config import ModelConfig


class RequestEncoder(nn.Module):
    """Embeds the meaning, joins the other channels of :mod:`stroke_requests`, applies a linear map; zeros without a request."""

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.meanings = nn.Embedding(config.meanings + 1, config.asked_size)
        self.linear = nn.Linear(config.asked_size + len(CHANNELS) - 1, config.asked_size)

    def forward(self, asked: torch.Tensor) -> torch.Tensor:
        """Map request channels ``(B, T, 7)`` to features ``(B, T, asked_size)``."""
        specified = asked[..., :1]
        meaning = self.meanings(asked[..., -1].long()) * asked[..., 1:2]
        return functional.silu(self.linear(torch.cat([asked[..., :-1], meaning], -1))) * specified
