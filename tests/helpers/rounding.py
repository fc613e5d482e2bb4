"""How far two runs of one network may lie apart where only the order of its sums differs: another batch size, CPU or thread."""

import numpy as np

FIGURE = 64 * float(np.finfo(np.float64).eps) ** 0.5
"""Difference of a figure of the same weights, of its own size or of 1: roots of covariances and inverses by singular values
keep at least half of float64's digits, in each of some 64 columns. The order of LAPACK's sums is up to threads and memory."""


def bound(checkpoint) -> float:
    """Largest difference of directions: float32 rounding of the widest product, carried through all that follow it.

    A sum of n products is off by at most n roundings of its terms. A regressor's recurrent state hands that on from frame to
    frame of a window, and its gates do not enlarge it; a flow hands it on from product to product and from step to step.
    """
    return bound_of(checkpoint.generator, checkpoint.window[0])


def bound_of(generator, window: int) -> float:
    """The same of a network that performs ``window`` frames at once."""
    widest = max(weight.shape[-1] for weight in generator.parameters() if weight.dim() == 2)
    return float(np.finfo(np.float32).eps) / 2 * widest * _depth(generator, window)


def same_figures(one: dict, two: dict) -> None:
    """Assert that ``{system: {figure: [mean, deviation]}}`` of two runs differ by rounding alone."""
    assert one.keys() == two.keys()
    for system in one:
        assert one[system].keys() == two[system].keys()
        for figure, values in one[system].items():
            np.testing.assert_allclose(two[system][figure], values, rtol=FIGURE, atol=FIGURE, err_msg=f"{system}: {figure}")


def _depth(generator, window: int) -> int:
    if not generator.noise_size:
        return window
    from s2ag.core.model.flow import STEPS

    return STEPS * 3 * (len(generator.denoiser.blocks) + 1)
