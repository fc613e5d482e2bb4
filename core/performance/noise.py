"""The random numbers that a performance is drawn from: those of a seed and a take, wherever one looks."""

import numpy as np

_SALT = 0xF10
_BLOCK = 256
"""Frames that share a generator, so that any part of an hour is at hand without what comes before it."""


def noise(seed: int, identity: tuple, start: int, stop: int, size: int) -> np.ndarray:
    """Normal numbers ``(stop - start, size)`` float32 of the frames from ``start`` to ``stop`` of one take.

    ``identity`` is ``(take, steps)`` as :func:`styles.identities` gives it: each step ``(number, spread)`` turns the numbers
    by that share of a right angle towards others, so that a variation shares as much with the take as it is near to it.
    """
    take, steps = identity
    numbers, path = _fresh((seed, take), start, stop, size), ()
    for number, spread in steps:
        path = (*path, number)
        angle = 0.5 * np.pi * spread
        others = _fresh((seed, take, *path), start, stop, size)
        numbers = np.float32(np.cos(angle)) * numbers + np.float32(np.sin(angle)) * others
    return numbers


def _fresh(key: tuple, start: int, stop: int, size: int) -> np.ndarray:
    blocks = range(start // _BLOCK, -(-stop // _BLOCK))
    drawn = [np.random.default_rng((*key, _SALT, block)).standard_normal((_BLOCK, size), np.float32) for block in blocks]
    first = blocks.start * _BLOCK
    return np.concatenate(drawn)[start - first : stop - first]
