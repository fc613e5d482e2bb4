"""How a flow carries noise to a performance, and how far it looks: the same in torch and in numpy."""

import math
from collections.abc import Callable
from typing import TypeVar

from ..motion.skeleton import EDGES, FPS
from .config import ModelConfig
from .timing import MFCC_RATE

Array = TypeVar("Array")

STEPS = 6
"""Velocities that one performance takes: 2.4 degrees from what 24 give, arms on average, eight 1.8, four 3.9; variety and pace
are those of eight.
"""


def solve(velocity: Callable[[Array, float], Array], x: Array, steps: int = STEPS) -> Array:
    """Carry ``x`` from time 0 to 1 in ``steps`` evaluations of ``velocity(x, time)`` (Adams and Bashforth of second order)."""
    before = None
    for step in range(steps):
        now = velocity(x, step / steps)
        x = x + (now if before is None else 1.5 * now - 0.5 * before) / steps
        before = now
    return x


def noise_size(config: ModelConfig) -> int:
    """Random numbers a frame: nine directions and what else a frame has."""
    return 3 * len(EDGES) + config.extras


def noise_scale(config: ModelConfig) -> list[float]:
    """The size of each of them."""
    poses = 3 * len(EDGES)
    return [config.flow_noise] * poses + [config.flow_extras_noise] * config.extras


def affect_reach(config: ModelConfig) -> int:
    """Frames to each side on which a frame's affective features depend."""
    return 4 * (config.time_kernel // 2) + 3


def hears(config: ModelConfig) -> int:
    """Frames to each side on which the features of a frame depend."""
    text = 2 * (config.text_kernel // 2) * (2**config.text_levels - 1)
    voice = math.ceil((sum(kernel // 2 for kernel in config.mfcc_kernels) + 1) * FPS / MFCC_RATE)
    return max(text, voice, affect_reach(config), 3 * bool(config.prosody_features))


def looks(config: ModelConfig) -> int:
    """Frames to each side on which one velocity depends; a whole performance sees :data:`STEPS` times as far.

    Extras are drawn on poses that are drawn, so what they see and what those see add up.
    """
    denoisers = [config, config.of_extras()] if config.extras else [config]
    tokens = [3 + sum(dilation * (one.flow_kernel // 2) for dilation in one.flow_dilations) for one in denoisers]
    return config.flow_patch * sum(tokens)
