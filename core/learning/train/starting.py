"""Training that goes on from weights that are there, although the corpus has other speakers or hands."""

from os import PathLike

import torch

from ...model import checkpoint
from ...model.encoders import POSE
from ...model.flow import FlowGenerator


@torch.no_grad()
def start(generator: torch.nn.Module, path: str | PathLike) -> list[str]:
    """Give ``generator`` what the checkpoint ``path`` has learnt; returns the names of what begins anew.

    Parameters of the same name and shape are taken over; of flows that know hands and others that do not also what concerns
    the nine directions. Raises what :func:`checkpoint.load` raises.
    """
    known, anew = checkpoint.load(path).generator, []
    theirs = known.state_dict()
    for name, mine in generator.state_dict().items():
        if name in theirs and theirs[name].shape == mine.shape:
            mine.copy_(theirs[name])
        else:
            anew.append(name)
    if isinstance(generator, FlowGenerator) and isinstance(known, FlowGenerator):
        anew = _poses(generator.denoiser, known.denoiser, anew)
    return anew


def _poses(mine, known, anew: list[str]) -> list[str]:
    """Take over the nine directions' part of layers that see and give all numbers of a frame, where all else fits."""
    names = {"denoiser.into.weight", "denoiser.out.weight", "denoiser.out.bias"}
    if mine.patch != known.patch or not names <= set(anew) or mine.into.weight.shape[::2] != known.into.weight.shape[::2]:
        return anew
    sees, saw = (part.into.weight.unflatten(1, (part.patch, -1)) for part in (mine, known))
    sees[:, :, POSE:-1] = 0
    sees[:, :, :POSE], sees[:, :, -1] = saw[:, :, :POSE], saw[:, :, -1]  # the last one says which frames are given
    for name in ("weight", "bias"):
        gives, gave = (getattr(part.out, name).unflatten(0, (part.patch, -1)) for part in (mine, known))
        gives[:, :POSE] = gave[:, :POSE]
    return [name for name in anew if name not in names]
