"""How far two runs of one network may lie apart where only the order of its sums differs: another batch size, CPU or thread."""

import numpy as np


def bound(checkpoint) -> float:
    """Largest difference of directions: float32 rounding of the widest product, carried through the frames of a window.

    A sum of n products is off by at most n roundings of its terms; the recurrent state hands that on from frame to frame,
    and its gates do not enlarge it.
    """
    widest = max(weight.shape[-1] for weight in checkpoint.generator.parameters() if weight.dim() == 2)
    return float(np.finfo(np.float32).eps) / 2 * widest * checkpoint.window[0]
