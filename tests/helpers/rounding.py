"""How far two runs of one network may lie apart where only the order of its sums differs: another batch size, CPU or thread."""

import numpy as np


def bound(checkpoint) -> float:
    """Largest difference of directions: float32 rounding of the widest product, carried through all that follow it.

    A sum of n products is off by at most n roundings of its terms. A regressor's recurrent state hands that on from frame to
    frame of a window, and its gates do not enlarge it; a flow hands it on from product to product and from step to step.
    """
    widest = max(weight.shape[-1] for weight in checkpoint.generator.parameters() if weight.dim() == 2)
    return float(np.finfo(np.float32).eps) / 2 * widest * _depth(checkpoint)


def _depth(checkpoint) -> int:
    if not checkpoint.generator.noise_size:
        return checkpoint.window[0]
    from s2ag.core.model.flow import STEPS

    return STEPS * 3 * (len(checkpoint.generator.denoiser.blocks) + 1)
