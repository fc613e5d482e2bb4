"""The random numbers that a performance is drawn from: those of a seed and a take, wherever one looks."""

import math
import zlib
from collections.abc import Mapping

import numpy as np

from ..motion.skeleton import MEAN

_SALT = 0xF10
_POSE = MEAN.size
_BLOCK = 256
"""Frames that share a generator, so that any part of an hour is at hand without what comes before it."""


def noise(
    seed: int, identity: tuple, start: int, stop: int, size: int, who: Mapping[str, float] | None = None, salt: int = _SALT
) -> np.ndarray:
    """Normal numbers ``(stop - start, size)`` float32 of the frames from ``start`` to ``stop`` of one take.

    ``identity`` is ``(take, steps)`` as :func:`styles.identities` gives it: each step ``(number, spread)`` turns the numbers
    by that share of a right angle towards others, so that a variation shares as much with the take as it is near to it.
    ``who`` are the weights of the speakers that perform: each has numbers of his own, so that two characters do not move alike
    at the same seed, and a blend leads from one's to the other's. Without them they are those of the seed alone. With another
    ``salt`` they are others, of whatever is numbered so.
    """
    take, steps = identity
    numbers, path = _mixed((seed, take), who, start, stop, size, salt), ()
    for number, spread in steps:
        path = (*path, number)
        angle = 0.5 * np.pi * spread
        others = _mixed((seed, take, *path), who, start, stop, size, salt)
        numbers = np.float32(np.cos(angle)) * numbers + np.float32(np.sin(angle)) * others
    return numbers


def uniform(numbers: np.ndarray) -> np.ndarray:
    """Normal numbers as ones spread evenly between 0 and 1, neither of which they are."""
    return np.clip(0.5 + 0.5 * np.vectorize(math.erf, [float])(numbers / math.sqrt(2)), 1e-6, 1 - 1e-6)


def _mixed(key: tuple, who: Mapping[str, float] | None, start: int, stop: int, size: int, salt: int) -> np.ndarray:
    """Every speaker's own numbers by weight; their variance stays one."""
    if not who:
        return _fresh(key, start, stop, size, salt)
    scale = 1 / np.sqrt(sum(weight**2 for weight in who.values()))
    own = [(_fresh((*key, zlib.crc32(name.encode())), start, stop, size, salt), weight) for name, weight in who.items()]
    return np.sum([np.float32(weight * scale) * numbers for numbers, weight in own], axis=0)


def _fresh(key: tuple, start: int, stop: int, size: int, salt: int) -> np.ndarray:
    blocks = range(start // _BLOCK, -(-stop // _BLOCK))
    # The nine directions have the same numbers whether a network knows hands or not.
    widths = [min(size, _POSE), max(size - _POSE, 0)]
    generators = [np.random.default_rng((*key, salt, block)) for block in blocks]
    drawn = [np.concatenate([one.standard_normal((_BLOCK, width), np.float32) for width in widths], 1) for one in generators]
    first = blocks.start * _BLOCK
    return np.concatenate(drawn)[start - first : stop - first]
