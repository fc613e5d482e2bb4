"""The velocity of a flow, as :mod:`denoiser` learns it: depthwise convolutions, their channels scaled and shifted."""

from functools import partial
from typing import NamedTuple

import numpy as np

from ...threads import each
from ..config import ModelConfig
from .layers import Convolution, Linear, Norm, Weights, pad, product, silu, unit

_WAVES = 32
_PIECE = 256
"""Tokens of which a piece has at most so many: large enough for products, small enough for caches and for two cores."""


class Conditions(NamedTuple):
    """What is added to the blocks' input ``(T / patch, size)``, and each block's scales and shifts of the same shape."""

    heard: np.ndarray
    films: list[tuple[np.ndarray, np.ndarray]]
    room: "Room"


class Moments(NamedTuple):
    """What a moment adds to each block's scales and shifts ``(size,)``."""

    films: list[tuple[np.ndarray, np.ndarray]]


class Room:
    """Arrays in which all velocities of a take are computed, and its tokens in pieces that do not depend on who computes.

    ``hidden``: two with ``edge`` tokens of zeros at both ends; ``narrow`` and ``wide``: two spare ones of each size.
    """

    def __init__(self, tokens: int, size: int, wide: int, edge: int):
        count = max(-(-tokens // _PIECE), 1)
        bounds = [round(tokens * number / count) for number in range(count + 1)]
        self.pieces = [slice(*pair) for pair in zip(bounds, bounds[1:], strict=False)]
        self.edge = edge
        self.hidden = [np.zeros((tokens + 2 * edge, size), np.float32) for _ in range(2)]
        self.narrow = [np.empty((tokens, size), np.float32) for _ in range(2)]
        self.wide = [np.empty((tokens, wide), np.float32) for _ in range(2)]

    def inner(self, rows: slice) -> slice:
        """Where the tokens ``rows`` lie in what has edges."""
        return slice(rows.start + self.edge, rows.stop + self.edge)


class Block:
    """A depthwise convolution and two products around a shortcut."""

    def __init__(self, weights: Weights, dilation: int):
        self.taps, self.dilation = (weights / "conv")["weight"], dilation
        self.reach = dilation * (len(self.taps) // 2)
        self.scale, self.shift, self.widen, self.narrow = (
            Linear.of(weights / name) for name in ("scale", "shift", "widen", "narrow")
        )

    def __call__(self, x: np.ndarray, out: np.ndarray, film: tuple, moment: tuple, room: Room, rows: slice) -> None:
        """What the block makes of ``rows`` of ``x``, and they themselves, into ``out``; both are :attr:`Room.hidden`."""
        (y, spare), (wide, share) = ((part[rows] for part in pair) for pair in (room.narrow, room.wide))
        self._convolve(x, rows, room.edge, y, spare)
        unit(y, y)
        y *= np.add(film[0][rows], moment[0], out=spare)
        y += np.add(film[1][rows], moment[1], out=spare)
        self.narrow(silu(self.widen(y, wide), share), y)
        here = room.inner(rows)
        np.add(x[here], y, out=out[here])

    def _convolve(self, x: np.ndarray, rows: slice, edge: int, total: np.ndarray, spare: np.ndarray) -> None:
        first = rows.start + edge - self.reach
        for number, tap in enumerate(self.taps):
            start = first + number * self.dilation
            seen = np.multiply(x[start : start + len(total)], tap, out=spare if number else total)
            if number:
                total += seen


class Denoiser:
    """Noisy poses and conditions to velocities, in tokens of ``flow_patch`` frames.

    Conditions are linear in features and what each take has of its own up to the first bend, so that all takes share the
    features' part. ``own`` are the numbers of a frame that a take has of its own: its style, and poses where it sees them.
    """

    def __init__(self, weights: Weights, config: ModelConfig, own: int):
        self.patch, self.own = config.flow_patch, own
        self.into, self.out = (Convolution.of(weights / name) for name in ("into", "out"))
        self.norm = Norm(weights / "norm")
        self.blocks = [Block(weights / "blocks" / str(n), dilation) for n, dilation in enumerate(config.flow_dilations)]
        first, self.second = weights / "features" / "0", Linear.of(weights / "features" / "2")
        self.of_features, self.of_take = zip(*map(self._parted, (weights / "heard", first)), strict=True)
        self._time = [Linear.of(weights / "time" / name) for name in ("0", "2")]

    def _parted(self, weights: Weights) -> tuple[Linear, Linear]:
        """A layer on tokens of features and what a take has of its own as one on each."""
        weight = weights["weight"].reshape(len(weights["bias"]), self.patch, -1)
        features, own = np.split(weight, [weight.shape[2] - self.own], axis=2)
        return Linear(features.reshape(len(weight), -1), weights["bias"]), Linear(own.reshape(len(weight), -1))

    def heard(self, features: np.ndarray) -> list[np.ndarray]:
        """Of features ``(T, channels)``, what :meth:`conditions` of every take has in common."""
        tokens = self.fold(features)
        return [layer(tokens) for layer in self.of_features]

    def told(self, heard: list[np.ndarray], asked: np.ndarray) -> list[np.ndarray]:
        """The same where the last channels of the features, zero so far, are ``asked`` ``(T, n)``."""
        tokens, size = self.fold(asked), asked.shape[1]
        weights = [layer.weight.reshape(len(layer.weight), self.patch, -1)[..., -size:] for layer in self.of_features]
        pairs = zip(heard, weights, strict=True)
        # so small that it is as fast without BLAS, whose rounding hangs on how many threads it has just now
        return [known + np.einsum("ij,kj->ik", tokens, weight.reshape(len(weight), -1)) for known, weight in pairs]

    def conditions(self, heard: list[np.ndarray], own: np.ndarray) -> Conditions:
        """Of a take with numbers ``(T, own)`` of its own."""
        tokens = self.fold(own)
        added, wide = (part + layer(tokens) for part, layer in zip(heard, self.of_take, strict=True))
        edge = max(self.out.before, *(block.reach for block in self.blocks))
        room = Room(len(added), added.shape[1], len(self.blocks[0].widen.weight), edge)
        films = [tuple(np.empty_like(added) for _ in range(2)) for _ in self.blocks]

        def part(rows: slice) -> None:
            known = self.second(silu(wide[rows]))
            for block, film in zip(self.blocks, films, strict=True):
                block.scale(known, film[0][rows])
                block.shift(known, film[1][rows])

        each(part, room.pieces)
        return Conditions(added, films, room)

    def moments(self, time: float) -> Moments:
        """Of a time from 0 to 1."""
        first, second = self._time
        wide = second(silu(first(_waves(time))))
        return Moments([(product(wide, block.scale.weight)[0], product(wide, block.shift.weight)[0]) for block in self.blocks])

    def __call__(self, x: np.ndarray, mask: np.ndarray, conditions: Conditions, moments: Moments) -> np.ndarray:
        """Velocities ``(T, channels)`` of ``x``; ``mask`` ``(T, 1)`` is 1 on given frames."""
        room, given = conditions.room, pad(self.fold(np.concatenate([x, mask], axis=1)), self.into.before, self.into.after)
        hidden, other = room.hidden
        made = np.empty((len(conditions.heard), self.patch * x.shape[1]), np.float32)

        def enter(rows: slice) -> None:
            np.add(self.into.within(given, rows), conditions.heard[rows], out=hidden[room.inner(rows)])

        def normed(rows: slice) -> None:
            other[room.inner(rows)] = self.norm(hidden[room.inner(rows)])

        def leave(rows: slice) -> None:
            made[rows] = self.out.within(other[room.edge - self.out.before :], rows)

        each(enter, room.pieces)
        for block, film, moment in zip(self.blocks, conditions.films, moments.films, strict=True):
            each(partial(block, hidden, other, film, moment, room), room.pieces)
            hidden, other = other, hidden
        each(normed, room.pieces)
        each(leave, room.pieces)
        return made.reshape(len(made) * self.patch, -1)[: len(x)]

    def fold(self, x: np.ndarray) -> np.ndarray:
        """``(T, C)`` to tokens ``(T / patch, patch C)``; the last one is filled up with zeros."""
        x = pad(x, 0, -len(x) % self.patch)
        return x.reshape(len(x) // self.patch, -1)


def _waves(time: float) -> np.ndarray:
    """A time in 0..1 as sines and cosines ``(1, 64)`` (Vaswani et al. 2017)."""
    rates = np.float32(1000) * np.exp(np.float32(-np.log(1000)) * np.arange(_WAVES, dtype=np.float32) / np.float32(_WAVES))
    angles = np.float32(time) * rates
    return np.concatenate([np.sin(angles), np.cos(angles)])[None]
