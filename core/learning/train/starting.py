"""Training that goes on from weights that are there, although the corpus has other speakers or hands."""

from os import PathLike

import torch

from ...model import checkpoint
from ...model.encoders import POSE
from ...model.flow import FlowGenerator


@torch.no_grad()
def start(generator: torch.nn.Module, path: str | PathLike) -> list[str]:
    """Give ``generator`` what the checkpoint ``path`` has learnt; returns the names of what begins anew.

    Parameters of the same name and shape are taken over; of flows also the mean and the spread of the nine directions, whether
    they know hands or not. Raises what :func:`checkpoint.load` raises.
    """
    known, anew = checkpoint.load(path).generator, []
    theirs = known.state_dict()
    for name, mine in generator.state_dict().items():
        if name in theirs and theirs[name].shape == mine.shape:
            mine.copy_(theirs[name])
        else:
            anew.append(name)
    if isinstance(generator, FlowGenerator) and isinstance(known, FlowGenerator):
        for mine, value in ((generator.centre, known.centre), (generator.scale, known.scale)):
            mine[:POSE] = value[:POSE]
    return anew
