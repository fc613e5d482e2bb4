"""Masks of given frames in training windows: the start, the end, both, all but a gap, single frames, or none."""

from collections.abc import Callable

import numpy as np

MAX_END_FRAMES = 10
"""Largest number of given frames at the end: two thirds of a second."""


def draw_masks(rng: np.random.Generator, batch: int, frames: int, seeds: int, shares: dict[str, float]) -> np.ndarray:
    """Draw masks ``(batch, frames)`` of given frames, of kinds (:data:`KINDS`) with probabilities ``shares``, else empty."""
    if not seeds:
        return np.zeros((batch, frames), bool)
    names = list(shares)
    chances = np.array([shares[name] for name in names])
    kind = np.searchsorted(np.cumsum(chances), rng.random(batch), side="right")
    time = np.arange(frames)
    masks = np.zeros((batch, frames), bool)
    for number, name in enumerate(names):
        masks[kind == number] = KINDS[name](rng, int((kind == number).sum()), time, seeds)
    return masks


def _start(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    # As many frames as the previous window would pass on, or fewer, down to a single start pose.
    length = np.where(rng.random((count, 1)) < 0.5, seeds, rng.integers(1, seeds + 1, (count, 1)))
    return time < length


def _end(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    return time >= len(time) - rng.integers(1, MAX_END_FRAMES + 1, (count, 1))


def _both(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    return _start(rng, count, time, seeds) | _end(rng, count, time, seeds)


def _gap(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    length = rng.integers(len(time) // 8, 3 * len(time) // 4, (count, 1))
    first = (rng.random((count, 1)) * (len(time) - length)).astype(np.int64)
    return (time < first) | (time >= first + length)


def _frames(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    return rng.random((count, len(time))) < rng.choice([1, 2, 3], (count, 1)) / len(time)


def _seeds(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    return np.broadcast_to(time < seeds, (count, len(time)))


KINDS: dict[str, Callable] = {"seeds": _seeds, "start": _start, "end": _end, "both": _both, "gap": _gap, "frames": _frames}
"""Kinds of masks by name: functions ``draw(rng, count, time, seeds)`` that return masks ``(count, frames)``."""
