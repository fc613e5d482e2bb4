"""Dropout that costs a CPU little."""

import torch
from torch import nn
from torch.nn import functional


def dropout(x: torch.Tensor, p: float) -> torch.Tensor:
    """``x`` with a share ``p`` of its values zero and the rest scaled up.

    PyTorch draws a CPU's masks value by value, a twentieth of a whole training step. There, eight come of one draw, which
    rounds ``p`` to a 256th.
    """
    if x.device.type != "cpu":
        return functional.dropout(x, p)
    dropped = max(round(p * 256), 1)
    bits = torch.empty(-(-x.numel() // 8), dtype=torch.int64).random_(-(2**63), None).view(torch.uint8)
    kept = bits[: x.numel()].view(x.shape) >= dropped
    return x * kept.to(x.dtype).mul_(256 / (256 - dropped))


class Dropout(nn.Dropout):
    """:func:`dropout` in training, nothing in use."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Same shape."""
        return dropout(x, self.p) if self.training and self.p else x
