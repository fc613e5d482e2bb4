"""What the training loop and the bench ask of a system."""

from typing import Any, NamedTuple

import torch
from torch import nn

from ...motion.skeleton import EDGES, MEAN
from .sample import Sample


class Made(NamedTuple):
    """Directions ``(B, T, 9, 3)`` that a system made in training, and whatever its own losses need beside them."""

    directions: torch.Tensor
    extra: Any = None


class System(nn.Module):
    """A gesture system. ``performer`` and ``judge`` hold the weights of the two optimisers; most have no judge.

    ``rate`` and ``judge_rate`` are learning rates, ``clip`` the largest norm of the performer's gradient (0: any).
    """

    rate = 5e-4
    mixed = True  # whether low precision pays in training; not where products are small and frames are subtracted
    judge_rate = 1e-4
    clip = 0.0
    knows_speakers = False  # whether it performs as the speaker whose id it is given
    speakers = 0  # how many it knows itself; 0: those of the data set
    performer: nn.Module

    def __init__(self):
        super().__init__()
        self.judge: nn.Module | None = None
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    def make(self, sample: Sample, progress: float) -> Made:
        """Perform in training; ``progress`` is the share of the training that is done."""
        raise NotImplementedError

    def terms(self, sample: Sample, made: Made, progress: float) -> dict[str, torch.Tensor]:
        """Weighted loss terms of the performer, scalars."""
        raise NotImplementedError

    def judging(self, progress: float) -> bool:
        """Whether the judge learns at this point of the training."""
        return self.judge is not None

    def judge_loss(self, sample: Sample, made: torch.Tensor) -> torch.Tensor:
        """Loss of the judge at detached directions ``(B, T, 9, 3)``; only for systems that have one."""
        raise NotImplementedError

    def perform(self, sample: Sample) -> torch.Tensor:
        """Directions ``(B, T, 9, 3)`` in use, not normalised; a style is drawn with torch's own random numbers."""
        raise NotImplementedError

    def ids(self, speaker: torch.Tensor) -> torch.Tensor:
        """Its own ids of the data set's speakers ``(B,)``."""
        return speaker

    def directions(self, poses: torch.Tensor) -> torch.Tensor:
        """Mean-subtracted ``(B, T, 27)`` to directions ``(B, T, 9, 3)``."""
        return poses.unflatten(-1, (len(EDGES), 3)) + self.mean


def wide(channels: int, share: float, multiple: int = 8) -> int:
    """``channels`` at a share of the published width, a multiple of ``multiple`` and that at least."""
    return channels if share == 1 else max(multiple * round(channels * share / multiple), multiple)


def narrow(channels: int, share: float) -> int:
    """:func:`wide` for the small sizes: even, so that eight channels at a quarter are two."""
    return wide(channels, share, 2)
