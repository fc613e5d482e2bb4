"""The flow's solver, noise and receptive fields, shared by torch and numpy."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, TypeVar

from ..motion.skeleton import EDGES, FPS
from .config import ModelConfig
from .mfcc_timing import MFCC_RATE

Array = TypeVar("Array", bound=Any)


def time_grid(config: ModelConfig) -> list[float]:
    """Return the solver's time grid from 0 to 1, ``flow_steps`` + 1 values.

    The flow is most curved near the noise, so small first steps are more accurate: the mean arm error against 64 steps is
    1.3 degrees with four steps of bend 1.7, 2.3 with six equal ones (bend 1), 0.9 with five of bend 1.6."""
    return [(step / config.flow_steps) ** config.flow_bend for step in range(config.flow_steps + 1)]


def solve(velocity: Callable[[Array, float], Array], x: Array, times: Sequence[float]) -> Array:
    """Integrate ``velocity(x, time)`` from ``x`` over the grid ``times`` (second-order Adams-Bashforth)."""
    previous, previous_size = None, 0.0
    for time, end in pairwise(times):
        current, size = velocity(x, time), end - time
        x = x + size * (current if previous is None else current + 0.5 * size / previous_size * (current - previous))
        previous, previous_size = current, size
    return x


def noise_size(config: ModelConfig) -> int:
    """Return the number of noise values per frame: those of nine directions, and the extras."""
    return 3 * len(EDGES) + config.extras


def noise_scale(config: ModelConfig) -> list[float]:
    """Return the scale of each noise value of a frame."""
    poses = 3 * len(EDGES)
    return [config.flow_noise] * poses + [config.flow_extras_noise] * config.extras


def affect_reach(config: ModelConfig) -> int:
    """Return the receptive field of the affective features, in frames to each side."""
    return 4 * (config.time_kernel // 2) + 3


def feature_reach(config: ModelConfig) -> int:
    """Return the receptive field of all features, in frames to each side."""
    text = 2 * (config.text_kernel // 2) * (2**config.text_levels - 1)
    voice = math.ceil((sum(kernel // 2 for kernel in config.mfcc_kernels) + 1) * FPS / MFCC_RATE)
    return max(text, voice, affect_reach(config), 3 * bool(config.prosody_features))


def velocity_reach(config: ModelConfig) -> int:
    """Return the receptive field of one velocity, in frames to each side; a whole sample's is ``flow_steps`` times as large.

    Extras are conditioned on sampled poses, so the receptive fields of both denoisers add up."""
    configs = [config, config.extras_config()] if config.extras else [config]
    tokens = [3 + sum(dilation * (each.flow_kernel // 2) for dilation in each.flow_dilations) for each in configs]
    return config.flow_patch * sum(tokens)
