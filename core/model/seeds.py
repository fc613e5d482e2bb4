"""Network inputs for seed poses and other given poses."""

import torch
from torch.nn import functional

from ..motion.skeleton import MEAN


def seed_input(poses: torch.Tensor, frames: int) -> torch.Tensor:
    """Return the input ``(B, frames, 28)`` for poses ``(B, seeds, 9, 3)`` of a window's first frames (reference A.1).

    It holds mean-subtracted directions and a 1 in the last channel on the seed frames, zeros after them.
    """
    poses = poses[:, :frames]
    mask = poses.new_ones(*poses.shape[:2], 1)
    return functional.pad(given_input(poses, mask), (0, 0, 0, frames - poses.shape[1]))


def given_input(poses: torch.Tensor, mask: torch.Tensor, extras: torch.Tensor | None = None) -> torch.Tensor:
    """Return the input ``(B, T, 28 + extras)`` for poses ``(B, T, 9, 3)`` that are given where ``mask`` ``(B, T, 1)`` is 1.

    ``extras`` ``(B, T, n)`` are the channels of a frame beyond its directions.
    """
    numbers = (poses - torch.from_numpy(MEAN).to(poses)).flatten(2)
    if extras is not None:
        numbers = torch.cat([numbers, extras], -1)
    return torch.cat([numbers * mask, mask.to(numbers)], -1)
