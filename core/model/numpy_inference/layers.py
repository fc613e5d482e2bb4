"""Layers on ``(..., frames, channels)`` float32, built from a dictionary of weight arrays by name."""

from collections.abc import Mapping

import numpy as np

from ...matrix_products import matmul_transposed

_EPSILON = np.float32(1e-5)


class Weights:
    """Weight arrays under a prefix: ``weights / "encoder"`` extends the prefix, ``weights["bias"]`` returns an array."""

    def __init__(self, arrays: Mapping[str, np.ndarray], prefix: str = ""):
        self._arrays, self._prefix = arrays, prefix

    def __truediv__(self, name: str) -> "Weights":
        return Weights(self._arrays, f"{self._prefix}{name}.")

    def __getitem__(self, name: str) -> np.ndarray:
        return self._arrays[self._prefix + name]

    def get(self, name: str) -> np.ndarray | None:
        """Return the array, or None."""
        return self._arrays.get(self._prefix + name)


def product(x: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Multiply ``(..., n)`` by the transpose of ``(m, n)``: ``(..., m)``."""
    return matmul_transposed(x.reshape(-1, x.shape[-1]), weight).reshape(*x.shape[:-1], len(weight))


class Linear:
    """A linear layer."""

    def __init__(self, weight: np.ndarray, bias: np.ndarray | None = None):
        self.weight, self.bias = np.ascontiguousarray(weight, np.float32), bias

    @classmethod
    def of(cls, weights: Weights) -> "Linear":
        """Create the layer from its weight and, if there is one, its bias."""
        return cls(weights["weight"], weights.get("bias"))

    def __call__(self, x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Map ``(..., n)`` to ``(..., m)``, or with ``out``, which is filled and returned, ``(rows, n)`` to ``(rows, m)``."""
        y = product(x, self.weight) if out is None else matmul_transposed(x, self.weight, out)
        if self.bias is not None:
            y += self.bias
        return y


class Convolution:
    """Convolution along time that keeps the length: one matrix product of concatenated windows of ``kernel`` frames."""

    def __init__(self, weight: np.ndarray, bias: np.ndarray, dilation: int = 1, causal: bool = False):
        """``weight`` is ``(outputs, inputs, kernel)``; a causal convolution depends on no later frame."""
        self.kernel, self.dilation = weight.shape[2], dilation
        reach = (self.kernel - 1) * dilation
        self.before = reach if causal else reach // 2
        self.after = reach - self.before
        self._linear = Linear(weight.transpose(0, 2, 1).reshape(len(weight), -1), bias)

    @classmethod
    def of(cls, weights: Weights) -> "Convolution":
        """Create the layer from its weight and bias; axes of length 1 after time are dropped."""
        weight = weights["weight"]
        return cls(weight.reshape(weight.shape[:3]), weights["bias"])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Map ``(..., T, inputs)`` to ``(..., T, outputs)``."""
        return self.within(pad(x, self.before, self.after), slice(0, x.shape[-2]))

    def within(self, padded: np.ndarray, rows: slice) -> np.ndarray:
        """Return the output of ``rows`` alone; ``padded`` has ``before`` and ``after`` additional frames at its ends."""
        starts = range(0, self.kernel * self.dilation, self.dilation)
        taps = [padded[..., rows.start + start : rows.stop + start, :] for start in starts]
        return self._linear(np.concatenate(taps, axis=-1))


class Norm:
    """Layer normalisation over the channels of every frame, with learned scale and shift."""

    def __init__(self, weights: Weights):
        self.weight, self.bias = weights["weight"], weights["bias"]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Normalise ``x``; the result has the same shape."""
        y = normalize_channels(x)
        y *= self.weight
        y += self.bias
        return y


def normalize_channels(x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Normalise the last axis to zero mean and unit variance; ``out`` may be ``x``."""
    size = np.float32(x.shape[-1])
    y = np.subtract(x, np.einsum("...i->...", x)[..., None] / size, out=out)
    y *= 1 / np.sqrt(np.einsum("...i,...i->...", y, y)[..., None] / size + _EPSILON)
    return y


def pad(x: np.ndarray, before: int, after: int) -> np.ndarray:
    """Add frames of zeros at both ends."""
    return np.pad(x, [(0, 0)] * (x.ndim - 2) + [(before, after), (0, 0)])


def leaky_relu(x: np.ndarray, slope: float) -> np.ndarray:
    """Apply a leaky ReLU with ``slope`` in 0..1."""
    return np.maximum(x, x * np.float32(slope))


def relu(x: np.ndarray) -> np.ndarray:
    """Apply a ReLU in place."""
    return np.maximum(x, 0, out=x)


def silu(x: np.ndarray, spare: np.ndarray | None = None) -> np.ndarray:
    """Apply the SiLU (``x`` times its logistic function, a tanh) in place; ``spare`` is a buffer of the same shape."""
    x *= np.float32(0.5)
    share = np.tanh(x, out=spare)
    share += 1
    x *= share
    return x


def resample(x: np.ndarray, frames: int) -> np.ndarray:
    """Resample ``(..., T, C)`` to ``frames`` frames by linear interpolation between frame centres."""
    count = x.shape[-2]
    position = np.maximum((np.arange(frames) + 0.5) * (count / frames) - 0.5, 0)
    low = np.minimum(position.astype(int), count - 1)
    share = (position - low).astype(np.float32)[:, None]
    high = np.minimum(low + 1, count - 1)
    return x[..., low, :] * (1 - share) + x[..., high, :] * share
