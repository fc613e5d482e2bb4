"""How a flow carries noise to a performance, and how far it looks: the same in torch and in numpy."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

from ..motion.skeleton import EDGES, FPS
from .config import ModelConfig
from .timing import MFCC_RATE

Array = TypeVar("Array")


def times(config: ModelConfig) -> list[float]:
    """The moments from 0 to 1 between which a performance is carried, ``flow_steps`` + 1.

    The flow turns most where it leaves the noise, so that steps which begin small say more: arms on average are 1.3 degrees
    from what 64 steps give after four of bend 1.7, 2.3 after six equal ones (bend 1), 0.9 after five of bend 1.6.
    """
    return [(step / config.flow_steps) ** config.flow_bend for step in range(config.flow_steps + 1)]


def solve(velocity: Callable[[Array, float], Array], x: Array, times: Sequence[float]) -> Array:
    """Carry ``x`` through ``times`` by a ``velocity(x, time)`` at each but the last (Adams and Bashforth, second order)."""
    before, last = None, 0.0
    for time, end in pairwise(times):
        now, size = velocity(x, time), end - time
        x = x + size * (now if before is None else now + 0.5 * size / last * (now - before))
        before, last = now, size
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
    """Frames to each side on which one velocity depends; a whole performance sees ``flow_steps`` times as far.

    Extras are drawn on poses that are drawn, so what they see and what those see add up.
    """
    denoisers = [config, config.of_extras()] if config.extras else [config]
    tokens = [3 + sum(dilation * (one.flow_kernel // 2) for dilation in one.flow_dilations) for one in denoisers]
    return config.flow_patch * sum(tokens)
