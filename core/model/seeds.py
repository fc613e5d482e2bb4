"""Seed poses as the generator takes them."""

import torch
from torch.nn import functional

from ..motion.skeleton import MEAN


def seed_input(poses: torch.Tensor, frames: int) -> torch.Tensor:
    """Seeds ``(B, frames, 28)`` from poses ``(B, seeds, 9, 3)`` of a window's first frames (reference section A.1).

    Mean-subtracted directions and a one in the last channel on the seed frames, zeros after.
    """
    given = functional.pad((poses[:, :frames] - torch.from_numpy(MEAN).to(poses)).flatten(2), (0, 1), value=1.0)
    return functional.pad(given, (0, 0, 0, frames - given.shape[1]))
