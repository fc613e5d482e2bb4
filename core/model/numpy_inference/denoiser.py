"""Velocity network of the flow: inference of :mod:`denoiser` with pieces of tokens computed in parallel."""

from functools import partial
from typing import NamedTuple

import numpy as np

from ...threads import all_busy, parallel_map
from ..config import ModelConfig
from .layers import Convolution, Linear, Norm, Weights, normalize_channels, pad, product, silu

_FREQUENCIES = 32
_PIECE_TOKENS = 512, 1024
"""Most tokens of a piece, a minute or two: large enough that threads seldom wait for one another, small enough for caches. The
second where all threads have a take to draw, and pieces only part its work."""

Film = tuple[np.ndarray, np.ndarray]
"""Scale and shift of a block (feature-wise linear modulation)."""


class Conditions(NamedTuple):
    """An offset ``(T / patch, size)`` added to the input of the blocks, and each block's scales and shifts, same shape."""

    heard: np.ndarray
    films: list[Film]
    room: "Buffers"


class TimeModulation(NamedTuple):
    """Terms ``(size,)`` that a flow time adds to each block's scales and shifts."""

    films: list[Film]


class Buffers:
    """Buffers in which all velocities of a take are computed, and its pieces of tokens, which change rounding at most.

    ``hidden``: two with ``edge`` tokens of zeros at both ends; ``narrow`` and ``wide``: two temporary ones of each size."""

    def __init__(self, tokens: int, size: int, wide: int, edge: int):
        count = max(-(-tokens // _PIECE_TOKENS[all_busy()]), 1)
        bounds = [round(tokens * number / count) for number in range(count + 1)]
        self.pieces = [slice(*pair) for pair in zip(bounds, bounds[1:], strict=False)]
        self.edge = edge
        self.hidden = [np.zeros((tokens + 2 * edge, size), np.float32) for _ in range(2)]
        self.narrow = [np.empty((tokens, size), np.float32) for _ in range(2)]
        self.wide = [np.empty((tokens, wide), np.float32) for _ in range(2)]

    def inner(self, rows: slice) -> slice:
        """Return the rows of tokens ``rows`` in :attr:`hidden`."""
        return slice(rows.start + self.edge, rows.stop + self.edge)


class Block:
    """A residual block: depthwise convolution, modulation, and two linear layers."""

    def __init__(self, weights: Weights, dilation: int):
        self.taps, self.dilation = (weights / "conv")["weight"], dilation
        self.reach = dilation * (len(self.taps) // 2)
        self.scale, self.shift, self.widen, self.narrow = (
            Linear.of(weights / name) for name in ("scale", "shift", "widen", "narrow")
        )

    def __call__(self, x: np.ndarray, out: np.ndarray, film: Film, moment: Film, room: Buffers, rows: slice) -> None:
        """Write the block's output for ``rows`` of ``x`` into ``out``; both are :attr:`Buffers.hidden`."""
        (y, spare), (wide, share) = ((part[rows] for part in pair) for pair in (room.narrow, room.wide))
        self._convolve(x, rows.start + room.edge, y)
        normalize_channels(y, y)
        y *= np.add(film[0][rows], moment[0], out=spare)
        y += np.add(film[1][rows], moment[1], out=spare)
        self.narrow(silu(self.widen(y, wide), share), y)
        inner = room.inner(rows)
        np.add(x[inner], y, out=out[inner])

    def _convolve(self, x: np.ndarray, first: int, out: np.ndarray) -> None:
        """Fill ``out`` ``(n, size)`` with the convolution of the rows of ``x`` from ``first`` on."""
        around = x[first - self.reach : first + len(out) + self.reach]
        size, strides = (len(self.taps), *out.shape), (self.dilation * x.strides[0], *x.strides)
        np.einsum("ktc,kc->tc", np.lib.stride_tricks.as_strided(around, size, strides, writeable=False), self.taps, out=out)


class Denoiser:
    """Predicts velocities from noisy poses and conditions, in tokens of ``flow_patch`` frames.

    The first layer is linear in speech features and in the take's own channels, so all takes share the features' part.
    ``own`` is the number of those channels: the style, and the poses where the denoiser is conditioned on them."""

    def __init__(self, weights: Weights, config: ModelConfig, own: int):
        self.patch, self.own = config.flow_patch, own
        self.into, self.out = (Convolution.of(weights / name) for name in ("into", "out"))
        self.norm = Norm(weights / "norm")
        self.blocks = [Block(weights / "blocks" / str(n), dilation) for n, dilation in enumerate(config.flow_dilations)]
        first, self.second = weights / "features" / "0", Linear.of(weights / "features" / "2")
        self.of_features, self.of_take = zip(*map(self._split, (weights / "heard", first)), strict=True)
        self._time = [Linear.of(weights / "time" / name) for name in ("0", "2")]

    def _split(self, weights: Weights) -> tuple[Linear, Linear]:
        """Split a layer into one on the features and one on the take's own channels."""
        weight = weights["weight"].reshape(len(weights["bias"]), self.patch, -1)
        features, own = np.split(weight, [weight.shape[2] - self.own], axis=2)
        return Linear(features.reshape(len(weight), -1), weights["bias"]), Linear(own.reshape(len(weight), -1))

    def heard(self, features: np.ndarray) -> list[np.ndarray]:
        """Return the part of :meth:`conditions` that depends on features ``(T, channels)`` alone."""
        tokens = self.fold(features)
        return [layer(tokens) for layer in self.of_features]

    def told(self, heard: list[np.ndarray], asked: np.ndarray) -> list[np.ndarray]:
        """Add encoded stroke requests ``(T, n)``: the last channels of the features, which were zero so far."""
        tokens, size = self.fold(asked), asked.shape[1]
        weights = [layer.weight.reshape(len(layer.weight), self.patch, -1)[..., -size:] for layer in self.of_features]
        pairs = zip(heard, weights, strict=True)
        # Small enough to be as fast without BLAS, whose rounding depends on its current number of threads.
        return [part + np.einsum("ij,kj->ik", tokens, weight.reshape(len(weight), -1)) for part, weight in pairs]

    def conditions(self, heard: list[np.ndarray], own: np.ndarray) -> Conditions:
        """Return the conditions of a take from the shared part and the take's own channels ``(T, own)``."""
        tokens = self.fold(own)
        added, wide = (part + layer(tokens) for part, layer in zip(heard, self.of_take, strict=True))
        edge = max(self.out.before, *(block.reach for block in self.blocks))
        room = Buffers(len(added), added.shape[1], len(self.blocks[0].widen.weight), edge)
        films = [(np.empty_like(added), np.empty_like(added)) for _ in self.blocks]

        def fill_films(rows: slice) -> None:
            hidden = self.second(silu(wide[rows]))
            for block, film in zip(self.blocks, films, strict=True):
                block.scale(hidden, film[0][rows])
                block.shift(hidden, film[1][rows])

        parallel_map(fill_films, room.pieces)
        return Conditions(added, films, room)

    def moments(self, time: float) -> TimeModulation:
        """Return the modulation by a flow time in 0..1."""
        first, second = self._time
        wide = second(silu(first(_time_encoding(time))))
        return TimeModulation(
            [(product(wide, block.scale.weight)[0], product(wide, block.shift.weight)[0]) for block in self.blocks]
        )

    def __call__(self, x: np.ndarray, mask: np.ndarray, conditions: Conditions, moments: TimeModulation) -> np.ndarray:
        """Return velocities ``(T, channels)`` of ``x``; ``mask`` ``(T, 1)`` is 1 on given frames."""
        room, inputs = conditions.room, pad(self.fold(np.concatenate([x, mask], axis=1)), self.into.before, self.into.after)
        hidden, output = room.hidden
        velocities = np.empty((len(conditions.heard), self.patch * x.shape[1]), np.float32)

        def project_in(rows: slice) -> None:
            np.add(self.into.within(inputs, rows), conditions.heard[rows], out=hidden[room.inner(rows)])

        def normalise(rows: slice) -> None:
            output[room.inner(rows)] = self.norm(hidden[room.inner(rows)])

        def project_out(rows: slice) -> None:
            velocities[rows] = self.out.within(output[room.edge - self.out.before :], rows)

        parallel_map(project_in, room.pieces)
        for block, film, moment in zip(self.blocks, conditions.films, moments.films, strict=True):
            parallel_map(partial(block, hidden, output, film, moment, room), room.pieces)
            hidden, output = output, hidden
        parallel_map(normalise, room.pieces)
        parallel_map(project_out, room.pieces)
        return velocities.reshape(len(velocities) * self.patch, -1)[: len(x)]

    def fold(self, x: np.ndarray) -> np.ndarray:
        """Group frames ``(T, C)`` into tokens ``(T / patch, patch C)``; the last one is padded with zeros."""
        x = pad(x, 0, -len(x) % self.patch)
        return x.reshape(len(x) // self.patch, -1)


def _time_encoding(time: float) -> np.ndarray:
    """Encode a time in 0..1 as sines and cosines ``(1, 64)`` (Vaswani et al. 2017)."""
    steps = np.arange(_FREQUENCIES, dtype=np.float32)
    rates = np.float32(1000) * np.exp(np.float32(-np.log(1000)) * steps / np.float32(_FREQUENCIES))
    angles = np.float32(time) * rates
    return np.concatenate([np.sin(angles), np.cos(angles)])[None]
