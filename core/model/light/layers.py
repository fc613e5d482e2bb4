"""Layers as functions of ``(..., frames, channels)`` float32; what is learned lies in a dictionary of arrays by name."""

from collections.abc import Mapping

import numpy as np

from ...products import rows_by_rows

_EPSILON = np.float32(1e-5)


class Weights:
    """Learned arrays under a prefix; ``weights / "encoder"`` goes one name deeper, ``weights["bias"]`` takes one."""

    def __init__(self, arrays: Mapping[str, np.ndarray], prefix: str = ""):
        self._arrays, self._prefix = arrays, prefix

    def __truediv__(self, name: str) -> "Weights":
        return Weights(self._arrays, f"{self._prefix}{name}.")

    def __getitem__(self, name: str) -> np.ndarray:
        return self._arrays[self._prefix + name]

    def get(self, name: str) -> np.ndarray | None:
        """The array, or None."""
        return self._arrays.get(self._prefix + name)


def product(x: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """``(..., n)`` by ``(m, n)``: ``(..., m)``."""
    return rows_by_rows(x.reshape(-1, x.shape[-1]), weight).reshape(*x.shape[:-1], len(weight))


class Linear:
    """A product and a shift."""

    def __init__(self, weight: np.ndarray, bias: np.ndarray | None = None):
        self.weight, self.bias = np.ascontiguousarray(weight, np.float32), bias

    @classmethod
    def of(cls, weights: Weights) -> "Linear":
        """The layer that was learned under this name."""
        return cls(weights["weight"], weights.get("bias"))

    def __call__(self, x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """``(..., n)`` to ``(..., m)``; with ``out``, which is returned then, only ``(rows, n)`` to ``(rows, m)``."""
        y = product(x, self.weight) if out is None else rows_by_rows(x, self.weight, out)
        if self.bias is not None:
            y += self.bias
        return y


class Convolution:
    """Along time, as long as its input: one product of each window of ``kernel`` frames laid side by side."""

    def __init__(self, weight: np.ndarray, bias: np.ndarray, dilation: int = 1, causal: bool = False):
        """``weight`` ``(outputs, inputs, kernel)``; a causal one sees nothing that comes later."""
        self.kernel, self.dilation = weight.shape[2], dilation
        reach = (self.kernel - 1) * dilation
        self.before = reach if causal else reach // 2
        self.after = reach - self.before
        self._linear = Linear(weight.transpose(0, 2, 1).reshape(len(weight), -1), bias)

    @classmethod
    def of(cls, weights: Weights) -> "Convolution":
        """The layer that was learned under this name, whatever single axes stand behind time."""
        weight = weights["weight"]
        return cls(weight.reshape(weight.shape[:3]), weights["bias"])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """``(..., T, inputs)`` to ``(..., T, outputs)``."""
        return self.within(pad(x, self.before, self.after), slice(0, x.shape[-2]))

    def within(self, padded: np.ndarray, rows: slice) -> np.ndarray:
        """The same of these ``rows`` alone; ``padded`` has ``before`` and ``after`` more frames at its ends."""
        starts = range(0, self.kernel * self.dilation, self.dilation)
        taps = [padded[..., rows.start + start : rows.stop + start, :] for start in starts]
        return self._linear(np.concatenate(taps, axis=-1))


class Norm:
    """Every frame's channels, less their mean, over their deviation, then scaled and shifted as learned."""

    def __init__(self, weights: Weights):
        self.weight, self.bias = weights["weight"], weights["bias"]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Same shape."""
        y = unit(x)
        y *= self.weight
        y += self.bias
        return y


def unit(x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Layer normalisation over the last axis, without anything learned; ``out`` may be ``x``."""
    y = np.subtract(x, x.mean(axis=-1, keepdims=True), out=out)
    y /= np.sqrt(np.einsum("...i,...i->...", y, y)[..., None] / np.float32(y.shape[-1]) + _EPSILON)
    return y


def pad(x: np.ndarray, before: int, after: int) -> np.ndarray:
    """Frames of zeros at both ends."""
    return np.pad(x, [(0, 0)] * (x.ndim - 2) + [(before, after), (0, 0)])


def leaky(x: np.ndarray, slope: float) -> np.ndarray:
    """What is negative, ``slope`` times as large."""
    return np.maximum(x, x * np.float32(slope))


def relu(x: np.ndarray) -> np.ndarray:
    """What is negative, zero; in place."""
    return np.maximum(x, 0, out=x)


def silu(x: np.ndarray, spare: np.ndarray | None = None) -> np.ndarray:
    """``x`` times its logistic; in place. ``spare`` is room of the same shape."""
    share = np.negative(x, out=spare)
    with np.errstate(over="ignore"):  # far below zero the exponential is infinite, and the result zero as it should be
        np.exp(share, out=share)
    share += 1
    x /= share
    return x


def resampled(x: np.ndarray, frames: int) -> np.ndarray:
    """``(..., T, C)`` to ``frames`` frames, linearly between the middles of the old ones."""
    count = x.shape[-2]
    at = np.maximum((np.arange(frames) + 0.5) * (count / frames) - 0.5, 0)
    low = np.minimum(at.astype(int), count - 1)
    share = (at - low).astype(np.float32)[:, None]
    high = np.minimum(low + 1, count - 1)
    return x[..., low, :] * (1 - share) + x[..., high, :] * share
