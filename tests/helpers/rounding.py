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
    return bound_of(checkpoint.network, checkpoint.window[0])


def bound_of(network, window: int) -> float:
    """The same of a network that performs ``window`` frames at once."""
    return float(np.finfo(np.float32).eps) / 2 * _widest(network.config) * _depth(network.config, window)


def same_figures(one: dict, two: dict) -> None:
    """Assert that ``{system: {figure: [mean, deviation]}}`` of two runs differ by rounding alone."""
    assert one.keys() == two.keys()
    for system in one:
        assert one[system].keys() == two[system].keys()
        for figure, values in one[system].items():
            np.testing.assert_allclose(two[system][figure], values, rtol=FIGURE, atol=FIGURE, err_msg=f"{system}: {figure}")


def _widest(config) -> int:
    """Terms of the longest sum in any product."""
    text = max(config.word_size, config.text_channels * config.text_kernel)
    if config.decoder == "flow":
        return max(text, config.flow_size * max(config.flow_expand, 3))
    return max(text, config.gru_size * 2, config.affect_size + config.mfcc_size + config.text_size + config.style_size)


def _depth(config, window: int) -> int:
    if config.decoder != "flow":
        return window
    blocks = len(config.flow_dilations) + (1 + len(config.flow_extras_dilations) if config.extras else 0)
    return config.flow_steps * 3 * (blocks + 1)
