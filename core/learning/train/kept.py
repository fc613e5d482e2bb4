"""Which frames of a training window are given: the start, an end, both, all but a gap, single frames, or none."""

from collections.abc import Callable

import numpy as np

LONGEST_END = 10
"""Frames of an end pose at most; two thirds of a second."""


def draw_kept(rng: np.random.Generator, batch: int, frames: int, seeds: int, shares: dict[str, float]) -> np.ndarray:
    """Masks ``(batch, frames)`` of given frames, kinds drawn with ``shares`` (:data:`KINDS`); what they lack of one is none."""
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
    # As many as a window before would hand on, or fewer: a single pose to start from.
    length = np.where(rng.random((count, 1)) < 0.5, seeds, rng.integers(1, seeds + 1, (count, 1)))
    return time < length


def _end(rng: np.random.Generator, count: int, time: np.ndarray, seeds: int) -> np.ndarray:
    return time >= len(time) - rng.integers(1, LONGEST_END + 1, (count, 1))


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
"""What can be given, by name: ``draw(rng, count, time, seeds)`` to masks ``(count, frames)``."""
