"""Interface of gesture systems for the bench's training loop and evaluation."""

from typing import Any, NamedTuple

import torch
from torch import nn

from ...motion.skeleton import EDGES, MEAN
from .sample import Sample


class Generated(NamedTuple):
    """Directions ``(B, T, 9, 3)`` that a system generates in training, and further data for its losses."""

    directions: torch.Tensor
    extra: Any = None


class System(nn.Module):
    """A gesture system. ``performer`` (generator) and ``judge`` (discriminator; most have none) have separate optimisers.

    ``rate`` and ``judge_rate`` are learning rates, ``clip`` is the largest norm of the performer's gradient (0: any).
    """

    rate = 5e-4
    mixed = True  # whether mixed precision helps; not with small matrix products and losses on frame differences
    judge_rate = 1e-4
    clip = 0.0
    knows_speakers = False  # whether its output depends on the speaker id
    speakers = 0  # number of its own speakers; 0: those of the data set
    performer: nn.Module
    mean: torch.Tensor

    def __init__(self):
        super().__init__()
        self.judge: nn.Module | None = None
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate in training; ``progress`` is the share of the training that is done."""
        raise NotImplementedError

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the weighted loss terms of the performer, scalars."""
        raise NotImplementedError

    def judge_active(self, progress: float) -> bool:
        """Return whether the judge is trained at this point of the training."""
        return self.judge is not None

    def judge_loss(self, sample: Sample, made: torch.Tensor) -> torch.Tensor:
        """Return the judge's loss for detached directions ``(B, T, 9, 3)``; only for systems with a judge."""
        raise NotImplementedError

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate directions ``(B, T, 9, 3)`` in use, not normalised; styles use torch's global random numbers."""
        raise NotImplementedError

    def ids(self, speaker: torch.Tensor) -> torch.Tensor:
        """Convert the data set's speaker ids ``(B,)`` to the system's own."""
        return speaker

    def directions(self, poses: torch.Tensor) -> torch.Tensor:
        """Convert mean-subtracted poses ``(B, T, 27)`` to directions ``(B, T, 9, 3)``."""
        return poses.unflatten(-1, (len(EDGES), 3)) + self.mean


def scale_width(channels: int, share: float, multiple: int = 8) -> int:
    """Scale a published width by ``share``, rounded to a multiple of ``multiple`` and at least that."""
    return channels if share == 1 else max(multiple * round(channels * share / multiple), multiple)


def scale_small_width(channels: int, share: float) -> int:
    """Scale a small width by ``share`` as :func:`scale_width`, rounded to an even number: a quarter of eight channels is
    two.
    """
    return scale_width(channels, share, 2)
