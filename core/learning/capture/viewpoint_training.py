"""Learns the networks of :mod:`viewpoint` from films by cameras whose places are known. Needs PyTorch."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import nn

from . import viewpoint

_WIDTH, _DROPPED, _TREMBLE = 192, 0.2, 0.6
_EPOCHS, _BATCH, _RATE, _DECAY = 30, 256, 3e-3, 1e-2
_SMALL = 0.2
"""Errors, in units of the network, below which they count squared."""
_NETWORKS = 3


def learn(seen: Sequence[np.ndarray], known: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the weights that features ``(n, d)`` of films and the ``known`` angles ``(n, 2)`` of their cameras teach."""
    rows, wanted = np.concatenate(seen), np.concatenate(known)
    mean, size = rows.mean(0), rows.std(0) + 1e-2
    scaled = torch.tensor(np.clip((rows - mean) / size, -viewpoint.FAR, viewpoint.FAR), dtype=torch.float32)
    learned = {"mean": mean, "size": size, "networks": np.array(_NETWORKS)}
    for number in range(_NETWORKS):
        torch.manual_seed(number)
        net = _network(len(mean))
        _train(net, scaled, torch.tensor(wanted / viewpoint.UNIT, dtype=torch.float32))
        for name, layer in zip(("first", "second", "last"), (part for part in net if isinstance(part, nn.Linear)), strict=True):
            learned[f"{number}.{name}"] = layer.weight.detach().numpy().T.astype(np.float16)
            learned[f"{number}.{name}_bias"] = layer.bias.detach().numpy().astype(np.float16)
    return learned


def _network(size: int) -> nn.Sequential:
    between = nn.ReLU(), nn.Dropout(_DROPPED)
    return nn.Sequential(nn.Linear(size, _WIDTH), *between, nn.Linear(_WIDTH, _WIDTH), *between, nn.Linear(_WIDTH, 2))


def _train(net: nn.Sequential, rows: torch.Tensor, wanted: torch.Tensor) -> None:
    batches = -(-len(rows) // _BATCH)
    optimizer = torch.optim.AdamW(net.parameters(), lr=_RATE, weight_decay=_DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, _RATE, total_steps=_EPOCHS * batches)
    for _ in range(_EPOCHS):
        for chosen in torch.randperm(len(rows)).split(_BATCH):
            made = net(rows[chosen] + _TREMBLE * torch.randn(len(chosen), rows.shape[1]))
            loss = nn.functional.smooth_l1_loss(made, wanted[chosen], beta=_SMALL)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
