"""Dropout that is fast on a CPU."""

import torch
from torch import nn
from torch.nn import functional


def dropout(x: torch.Tensor, p: float) -> torch.Tensor:
    """Set a share ``p`` of the values of ``x`` to zero and scale up the rest.

    On a CPU, PyTorch draws masks value by value, which takes a twentieth of a whole training step. Here one random integer
    gives eight mask values, which rounds ``p`` to a multiple of 1/256.
    """
    if x.device.type != "cpu":
        return functional.dropout(x, p)
    dropped = max(round(p * 256), 1)
    bits = torch.empty(-(-x.numel() // 8), dtype=torch.int64).random_(-(2**63), None).view(torch.uint8)
    kept = bits[: x.numel()].view(x.shape) >= dropped
    return x * kept.to(x.dtype).mul_(256 / (256 - dropped))


class Dropout(nn.Dropout):
    """Module of :func:`dropout`; the identity in evaluation mode."""

    def forward(self, input: torch.Tensor) -> torch.Tensor:
        """Apply dropout in training; the result has the same shape."""
        return dropout(input, self.p) if self.training and self.p else input
