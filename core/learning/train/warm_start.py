"""Initialises a training from a checkpoint whose speakers or hands may differ from the corpus's."""

from os import PathLike

import torch

from ...model import checkpoint
from ...model.encoders import POSE
from ...model.flow import FlowGenerator


@torch.no_grad()
def copy_weights(generator: torch.nn.Module, path: str | PathLike) -> list[str]:
    """Copy matching parameters of the checkpoint ``path`` into ``generator``; returns the names of those not copied.

    Parameters match in name and shape. For flows, mean and scale of the nine directions are copied even if one of them
    has no hands. Raises what :func:`checkpoint.load` raises.
    """
    source, not_copied = checkpoint.load(path).generator, []
    theirs = source.state_dict()
    for name, mine in generator.state_dict().items():
        if name in theirs and theirs[name].shape == mine.shape:
            mine.copy_(theirs[name])
        else:
            not_copied.append(name)
    if isinstance(generator, FlowGenerator) and isinstance(source, FlowGenerator):
        for mine, value in ((generator.centre, source.centre), (generator.scale, source.scale)):
            mine[:POSE] = value[:POSE]
    return not_copied
