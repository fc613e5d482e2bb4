"""The velocity of a flow, as :mod:`denoiser` learns it: depthwise convolutions, their channels scaled and shifted."""

from typing import NamedTuple

import numpy as np

from ..config import ModelConfig
from .layers import Convolution, Linear, Norm, Weights, pad, product, silu, unit

_WAVES = 32


class Conditions(NamedTuple):
    """What is added to the blocks' input ``(T / patch, size)``, and each block's scales and shifts of the same shape."""

    heard: np.ndarray
    films: list[tuple[np.ndarray, np.ndarray]]


class Moments(NamedTuple):
    """What a moment adds to each block's scales and shifts ``(size,)``."""

    films: list[tuple[np.ndarray, np.ndarray]]


class Block:
    """A depthwise convolution and two products around a shortcut."""

    def __init__(self, weights: Weights, dilation: int):
        self.taps, self.dilation = (weights / "conv")["weight"], dilation
        self.scale, self.shift, self.widen, self.narrow = (
            Linear.of(weights / name) for name in ("scale", "shift", "widen", "narrow")
        )

    def __call__(self, x: np.ndarray, film: tuple, moment: tuple) -> None:
        """Add what the block makes of ``(T, size)`` to it."""
        y = unit(self._convolved(x))
        y *= film[0] + moment[0]
        y += film[1]
        y += moment[1]
        x += self.narrow(silu(self.widen(y)))

    def _convolved(self, x: np.ndarray) -> np.ndarray:
        reach, frames = self.dilation * (len(self.taps) // 2), len(x)
        padded = pad(x, reach, reach)
        total = padded[:frames] * self.taps[0]
        for number in range(1, len(self.taps)):
            total += padded[number * self.dilation : number * self.dilation + frames] * self.taps[number]
        return total


class Denoiser:
    """Noisy poses and conditions to velocities, in tokens of ``flow_patch`` frames.

    Conditions are linear in features and styles up to the first bend, so that all takes share the features' part.
    """

    def __init__(self, weights: Weights, config: ModelConfig):
        self.patch, self.styled = config.flow_patch, config.style_size
        self.into, self.out = (Convolution.of(weights / name) for name in ("into", "out"))
        self.norm = Norm(weights / "norm")
        self.blocks = [Block(weights / "blocks" / str(n), dilation) for n, dilation in enumerate(config.flow_dilations)]
        first, self.second = weights / "features" / "0", Linear.of(weights / "features" / "2")
        self.of_features, self.of_styles = zip(*map(self._parted, (weights / "heard", first)), strict=True)
        self._time = [Linear.of(weights / "time" / name) for name in ("0", "2")]

    def _parted(self, weights: Weights) -> tuple[Linear, Linear]:
        """A layer on tokens of features and styles as one on each."""
        weight = weights["weight"].reshape(len(weights["bias"]), self.patch, -1)
        features, styles = np.split(weight, [weight.shape[2] - self.styled], axis=2)
        return Linear(features.reshape(len(weight), -1), weights["bias"]), Linear(styles.reshape(len(weight), -1))

    def heard(self, features: np.ndarray) -> list[np.ndarray]:
        """Of features ``(T, channels)``, what :meth:`conditions` of every take has in common."""
        tokens = self.fold(features)
        return [layer(tokens) for layer in self.of_features]

    def conditions(self, heard: list[np.ndarray], style: np.ndarray, frames: int) -> Conditions:
        """Of a take with style ``(size,)``, or ``(T, size)`` where it walks."""
        tokens = self.fold(np.broadcast_to(style, (frames, self.styled)))
        added, wide = (part + layer(tokens) for part, layer in zip(heard, self.of_styles, strict=True))
        wide = self.second(silu(wide))
        return Conditions(added, [(block.scale(wide), block.shift(wide)) for block in self.blocks])

    def moments(self, time: float) -> Moments:
        """Of a time from 0 to 1."""
        first, second = self._time
        wide = second(silu(first(_waves(time))))
        return Moments([(product(wide, block.scale.weight)[0], product(wide, block.shift.weight)[0]) for block in self.blocks])

    def __call__(self, x: np.ndarray, mask: np.ndarray, conditions: Conditions, moments: Moments) -> np.ndarray:
        """Velocities ``(T, channels)`` of ``x``; ``mask`` ``(T, 1)`` is 1 on given frames."""
        hidden = self.into(self.fold(np.concatenate([x, mask], axis=1)))
        hidden += conditions.heard
        for block, film, moment in zip(self.blocks, conditions.films, moments.films, strict=True):
            block(hidden, film, moment)
        made = self.out(self.norm(hidden))
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
