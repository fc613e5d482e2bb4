"""Draws performances of any length from noise: all frames at once, a long recording in tiles.

A frame depends only on those within the network's receptive field, so a tile with that much around it is what one evaluation of
the whole would give there, without seams. Takes are drawn one by one, in parallel where there are cores, so that none depends
on those beside it."""

import itertools
import threading
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..errors import Cancelled
from ..model.mfcc_timing import PHASE_PERIOD
from ..model.noise import BEYOND, in_bands, noise
from ..motion import hand_channels, skeleton
from ..threads import parallel_map
from . import hand_synthesis
from .style_sequence import StyleSequence
from .time_warp import Inputs, TimeWarp

TILE = 8192
"""Frames that are drawn at once, 9 minutes; those around them come on top."""


def sample(
    network: Any, inputs: Inputs, cast: Sequence[StyleSequence], asked: Sequence[np.ndarray | None], frames: int,
    progress: Callable[[float], None] = lambda value: None, cancelled: Callable[[], bool] = lambda: False, tile: int = TILE,
    lively: Sequence[np.ndarray] | None = None, tempo: TimeWarp | None = None
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Draw directions ``(takes, frames, 9, 3)`` float32 of all takes of the ``cast``, and the extra channels of their frames
    ``(takes, frames, extras)``.

    ``network`` is a :class:`NumpyNetwork` or has its interface. ``inputs`` are as for :func:`windows.generate`;
    ``asked`` ``(takes, frames, 7)`` are the strokes asked of each performer's takes (:mod:`stroke_requests`), None for none.
    Given frames (:meth:`StyleSequence.given`) are kept, and only the others are computed. ``lively`` has for each performer
    ``(frames, 10, 2)``, scales of the noise of directions and hands in bands: below 1 all is nearer to what is usual.
    ``tempo`` warps time; all else is in frames of the recording."""
    scales = [None] * len(cast) if lively is None else lively
    plans = [_Plan(network, *each, frames, tile, tempo) for each in zip(cast, asked, scales, strict=True)]
    drawings = (2 if network.config.extras else 1) * sum(len(plan.tiles) * len(plan.performers.latents) for plan in plans)
    steps = max(network.config.flow_steps * drawings, 1)
    done, asking = itertools.count(), threading.get_ident()

    def begins() -> None:
        share = next(done) / steps
        if threading.get_ident() != asking:
            return  # progress and cancelling belong to the calling thread
        if cancelled():
            raise Cancelled("Cancelled.")
        progress(share)

    made = [plan.draw(inputs, begins) for plan in plans]
    progress(1.0)
    directions, extras = (np.concatenate(part) for part in zip(*made, strict=True))
    return directions, extras


class _Plan:
    """The inputs of one request's drawing, in the performance's time, and its tiles."""

    def __init__(self, network, performers: StyleSequence, asked: np.ndarray | None, lively, frames: int, tile: int, tempo):
        self.network, self.performers, self.asked, self.tempo = network, performers, asked, tempo
        self.kept = self.mask, self.poses = performers.given(frames).whole(frames)
        self.styles = performers.on_the_way(frames if performers.varies else 1)
        scale = performers.chance(frames)[:, None] * (np.ones((1, 10, 2)) if lively is None else lively)
        self.lively = scale[:, np.minimum(np.arange(network.noise_size) // 3, 9)].astype(np.float32)
        if tempo is not None:
            self.mask, self.poses = tempo.given(*self.kept)
            self.lively = tempo.along(self.lively)
            self.asked = None if asked is None else np.stack([tempo.along(one) for one in asked])
            self.styles = np.stack([tempo.along(one) for one in self.styles]) if performers.varies else self.styles
        self.extras = _extras(network.usual, self.mask, self.poses)
        self.tiles = list(_tiles(network, np.flatnonzero(~self.mask), tile))

    def draw(self, inputs, begins: Callable[[], None]) -> tuple[np.ndarray, np.ndarray]:
        """Return ``(takes, frames, 9, 3)`` and ``(takes, frames, extras)``; ``begins()`` is called before each step."""
        network, performers, tempo = self.network, self.performers, self.tempo
        inputs = inputs if tempo is None else tempo.heard(inputs)
        made, extras = (np.repeat(part[None], len(performers.latents), 0) for part in (self.poses, self.extras))
        for place in self.tiles:
            low, high = place[2:]
            seeds = self._seeds(low, high)
            mfcc, words, prosody = _heard(inputs, low, high)
            heard = network.hear(mfcc, words, seeds, prosody)
            take = partial(self._draw_take, (made, extras), place, heard, seeds, begins)
            parallel_map(take, range(len(made)), 2 * TILE // (high - low) if network.shares else 1)
        made[:, self.mask], extras[:, self.mask] = self.poses[self.mask], self.extras[self.mask]
        return (made, extras) if tempo is None else self._played(made, extras)

    def _played(self, made: np.ndarray, extras: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Convert a performance to the recording's frames, each take with strokes on accents, and put the given ones in."""
        warps = [self.tempo.on_accents(take, self.kept[0]) for take in made]
        made, extras = (np.stack([warp.back(take) for warp, take in zip(warps, part, strict=True)]) for part in (made, extras))
        made, (mask, poses) = skeleton.normalize(made), self.kept
        made[:, mask], extras[:, mask] = poses[mask], _extras(self.network.usual, mask, poses)[mask]
        return made, extras

    def _draw_take(self, wholes: tuple, place: tuple, heard, seeds: np.ndarray, begins: Callable[[], None], row: int) -> None:
        """Draw a take's frames of one tile into the ``wholes``."""
        start, stop, low, high = place
        request = self.performers.request
        first, last = max(low - BEYOND, 0), high + BEYOND
        drawn = noise(request.keyed_seed, request.identities[row], first, last, self.network.noise_size, self.performers.who)
        drawn = in_bands(drawn, _cut(self.lively, first, last), first)[low - first : high - first]
        if self.asked is not None:
            heard = self.network.told(heard, _cut(self.asked[row], low, high))
        style = self.styles[row] if self.styles.ndim == 2 else _cut(self.styles[row], low, high)
        made = self.network.draw(heard, style, seeds, drawn, begins)
        for whole, part in zip(wholes, made, strict=True):
            whole[row, start:stop] = part[start - low : stop - low]

    def _seeds(self, low: int, high: int) -> np.ndarray:
        """Return given poses as the network takes them, ``(high - low, noise_size + 1)``; the last channel is their mask."""
        given = np.zeros((high - low, self.network.noise_size + 1), np.float32)
        frames, size = np.flatnonzero(self.mask[low:high]), skeleton.MEAN.size
        given[frames, :size] = (self.poses[low + frames] - skeleton.MEAN).reshape(-1, size)
        given[frames, size:-1] = self.extras[low + frames]
        given[frames, -1] = 1
        return given


def _extras(usual: np.ndarray, mask: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return the extra channels of frames ``(frames, extras)``: at given ones, hands as they hang on such arms."""
    extras = np.tile(usual.astype(np.float32), (len(poses), 1))
    if len(usual) == hand_channels.SIZE:
        extras[mask] = hand_channels.to_channels(hand_synthesis.hanging_hands(poses[mask]), poses[mask])
    return extras


def _tiles(network, free: np.ndarray, tile: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield ``start, stop, low, high``: frames from ``start`` to ``stop`` come from an evaluation of ``low`` to ``high``.

    ``free`` are the frames to draw. Those before the first and after the last of them are known at every step, so that the
    receptive field of one step is enough there; between tiles it is that of all steps."""
    if not len(free):
        return
    first, last = int(free[0]), int(free[-1]) + 1
    step = int(np.lcm(PHASE_PERIOD, network.config.flow_patch))
    for start in range(first, last, tile):
        stop = min(start + tile, last)
        steps = network.config.flow_steps
        before, after = (
            network.velocity_reach * (1 if edge else steps) + network.hears for edge in (start == first, stop == last)
        )
        low = max(start - before, 0) // step * step
        yield start, stop, low, -(-(stop + after) // step) * step


def _heard(inputs, low: int, high: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return the inputs from ``low`` to ``high``, repeating the last ones beyond the end; float32."""
    mfcc, words, prosody = inputs(low, high)
    prosody = None if prosody is None else _cut(np.asarray(prosody, np.float32), 0, high - low)
    return np.asarray(mfcc, np.float32), np.asarray(words, np.float32), prosody


def _cut(values: np.ndarray, low: int, high: int) -> np.ndarray:
    """Return rows ``low`` to ``high``, repeating the last one beyond the end."""
    return values[np.minimum(np.arange(low, high), len(values) - 1)]
